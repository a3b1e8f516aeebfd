#pragma once
/// Radiance transfer for a moving instance.

#include "shading/transfer/source_rows.h"

namespace haarfield {

/// T = light x BRDF x cosine x visibilities around all instances except the moving one, for each vertex of
/// the others. Each frame multiplies T by the occlusion of the moving instance. [W/(m^2 sr)]
///
/// The moving instance is evaluated by its field, also at small distances and for any
/// RenderSettings::occlusion. If it is rotated, or has too few triangles for samples in its field, new
/// samples of equal number and accuracy are computed.
///
/// The radiance of a vertex is  <T, 1> - sum of weight * <T, occlusion of a sample>  over the samples of the
/// moving instance's field that are interpolated at the vertex. Vertices that it does not occlude need no
/// work, and pruning does not affect them.
struct MotionTransfer {
    /// A row that the moving instance may shade, with its view.
    struct Viewpoint {
        std::uint32_t row;
        ShadingPoint point;
    };

    std::size_t instance = 0;           ///< Index of the moving instance.
    VisibilityField around;             ///< Samplers in its current rotation, without samples.
    SparseVectorBlocks vectors;         ///< RGB. Rows of the moving instance's own vertices are empty.
    std::vector<Rgb> open;              ///< By row: <T, 1>, the radiance without the moving instance,
                                        ///< including the visible sources.
    StaticSources sources;              ///< The sources and their visibility.
    std::vector<Viewpoint> viewpoints;  ///< Of the rows that are not empty.
    SparseVectorBlocks occlusions;      ///< occlusion_vectors of its field.
    /// Radiance of the moving instance before it moves, by vertex. The quality is that of
    /// FrameQuality::moving, but all vertices are shaded.
    std::vector<Rgb> own;
    std::vector<std::uint8_t> left_out;  ///< By vertex of the moving instance: 1 if it is not shaded during
                                         ///< motion.
    BuriedFill fill;                     ///< Fills in the changes at left-out vertices.
    LightPyramid light;

    /// Memory. [bytes]
    std::size_t bytes() const {
        return vectors.bytes() + open.size() * sizeof(Rgb) + viewpoints.size() * sizeof(Viewpoint) +
               sources.bytes() + occlusions.bytes();
    }
};

/// Computes the transfer vectors.
///
/// lights   of concentrated sources; fixed for the life of the vectors. The geometry's rays must be placed as
///          the scene is.
/// errors   interrupted.
/// cost     one or two RGB function products per vertex, rays to each light, and a copy of the instance's
///          field; and precompute_surroundings if that field cannot be used.
Result<MotionTransfer> motion_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                       const RenderSettings& settings, const TransferSettings& transfer,
                                       const RgbCubemapTree& light, std::vector<DirectionalLight> lights,
                                       std::size_t instance, const Progress& progress = {});

/// Computes the radiance with the moving instance in its current place. Its own vertices are shaded by
/// product integrals, since their whole visibility changes.
///
/// scene    that of the vectors, except for the instance's translation and scale; the geometry's rays are
///          placed alike.
/// errors   interrupted; `radiance` is then unchanged.
/// cost     one inner product per vertex within the instance's reach that has it above its horizon, with up
///          to eight samples at once; and its own vertices.
Result<Done> shade_frame(const MotionTransfer& transfer, const ShadedScene& scene,
                         const ShadingGeometry& geometry, const RenderSettings& settings,
                         FrameQuality quality, SceneColours& radiance, const Progress& progress = {});

}  // namespace haarfield
