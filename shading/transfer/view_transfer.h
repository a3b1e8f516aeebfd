#pragma once
/// Radiance transfer for an eye that moves.

#include "shading/transfer/lobe_vectors.h"
#include "shading/transfer/source_rows.h"

namespace haarfield {

/// T = light x visibilities x horizon x the material's specular weight, per vertex; to be multiplied with the
/// specular lobe of each frame. [W/(m^2 sr)]
struct ViewTransfer {
    /// A row that has highlights.
    struct Highlit {
        std::uint32_t row;
        std::uint32_t material;  ///< Place in `materials`.
        Vec3f position, normal;  ///< In the world.
    };

    SparseVectorBlocks specular;  ///< RGB. Empty rows where nothing is specular.
    std::vector<Rgb> diffuse;     ///< By row: the radiance that does not depend on the eye.
    LobeVectors lobes;
    std::vector<VertexBrdf> materials;  ///< Of all entities; without normal and mirror direction.
    std::vector<Highlit> highlit;       ///< The rows of `specular` that are not empty.
    SourceSights sights;                ///< Of what is concentrated.

    /// Memory. [bytes]
    std::size_t bytes() const {
        return specular.bytes() + diffuse.size() * sizeof(Rgb) + lobes.lobes.bytes() +
               highlit.size() * sizeof(Highlit) + sights.bytes();
    }
};

/// light    what is smooth,
/// sources  and what is not in it, as they stand now.
/// errors   interrupted.
/// cost     an RGB function product per vertex.
Result<ViewTransfer> view_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                   const RenderSettings& settings, const TransferSettings& transfer,
                                   const RgbCubemapTree& light, std::span<const LightSource> sources,
                                   const Progress& progress = {});

/// Radiance towards the scene's eye.
///
/// scene     with `geometry` the one that the vectors were made for, but for the eye.
/// vertices  null: all; else see store_radiance.
/// errors    interrupted; then `radiance` is as it was.
/// cost      one inner product per wanted vertex that has highlights, with four lobes side by side.
Result<Done> shade_frame(const ViewTransfer& transfer, const ShadedScene& scene,
                         const ShadingGeometry& geometry, SceneColours& radiance,
                         const VertexMask* vertices = nullptr, const Progress& progress = {});

}  // namespace haarfield
