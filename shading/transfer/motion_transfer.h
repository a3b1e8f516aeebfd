#pragma once
/// Radiance transfer for an instance that moves.

#include "shading/transfer/source_rows.h"

namespace haarfield {

/// T = light x BRDF x visibilities past all but the moving instance x cosine, per vertex of the others; to be
/// multiplied with what the moving one hides of each frame. [W/(m^2 sr)]
///
/// The moving instance is seen by its field, from near as well, whatever RenderSettings::occlusion says; if
/// it is turned, or has so few triangles that its field has no samples, by samples that are made for it,
/// which are as many and no less exact.
///
/// A vertex's radiance is  <T, 1> - sum of weight * <T, occlusion of a sample>  over the samples of the
/// moving instance's field that are interpolated at the vertex: where it hides nothing, nothing is to be
/// done, and nothing is lost by pruning.
struct MotionTransfer {
    /// A row that the moving instance may shade, and where it is seen from.
    struct Viewpoint {
        std::uint32_t row;
        VertexView view;
    };

    std::size_t instance = 0;           ///< Which one moves.
    VisibilityField around;             ///< Its samplers, as it is turned; without their samples.
    SparseVectorBlocks vectors;         ///< RGB. Empty rows for the moving instance's own vertices.
    std::vector<Rgb> open;              ///< By row: <T, 1>, the radiance without the moving instance,
    StandingSources sources;            ///< with what of these it then sees.
    std::vector<Viewpoint> viewpoints;  ///< Of the rows that are not empty.
    SparseVectorBlocks occlusions;      ///< occlusion_vectors of its field.
    /// Radiance of its own vertices before it moves, shaded as while it does, but all of them. By vertex.
    std::vector<Rgb> own;
    std::vector<std::uint8_t> left_out;  ///< Of these, those that are not shaded while it moves: 1.
    BuriedFill fill;                     ///< For what changes at them.
    LightPyramid light;

    /// Memory. [bytes]
    std::size_t bytes() const {
        return vectors.bytes() + open.size() * sizeof(Rgb) + viewpoints.size() * sizeof(Viewpoint) +
               sources.bytes() + occlusions.bytes();
    }
};

/// lights   of what is concentrated: they stay as long as the vectors. The geometry's rays must be placed as
///          the scene is.
/// errors   interrupted.
/// cost     one or two RGB function products per vertex, rays to each light, and a copy of the instance's
///          field; see precompute_surroundings if it has none that serves.
Result<MotionTransfer> motion_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                       const RenderSettings& settings, const TransferSettings& transfer,
                                       const RgbCubemapTree& light, std::vector<DirectionalLight> lights,
                                       std::size_t instance, const Progress& progress = {});

/// Radiance with the moving instance where the scene has it now. Its own vertices are shaded by product
/// integrals, since all that they see changes.
///
/// scene    the one that the vectors were made for, but for the instance's translation and scale; the
///          geometry's rays are placed alike.
/// errors   interrupted; then `radiance` is as it was.
/// cost     one inner product per vertex in the instance's reach that has it above its horizon, with up to
///          eight samples side by side; and its own vertices.
Result<Done> shade_frame(const MotionTransfer& transfer, const ShadedScene& scene,
                         const ShadingGeometry& geometry, const RenderSettings& settings,
                         FrameQuality quality, SceneColours& radiance, const Progress& progress = {});

}  // namespace haarfield
