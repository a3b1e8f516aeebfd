#pragma once
/// Radiance transfer for a moving eye.

#include "shading/transfer/lobe_vectors.h"
#include "shading/transfer/source_rows.h"

namespace haarfield {

/// T = light x visibilities x horizon x the material's specular weight, per vertex. Each frame multiplies T
/// by the specular lobe. [W/(m^2 sr)]
struct ViewTransfer {
    /// A row with specular reflection.
    struct Highlit {
        std::uint32_t row;
        std::uint32_t material;  ///< Index in `materials`.
        Vec3f position, normal;  ///< In the world.
    };

    SparseVectorBlocks specular;  ///< RGB. Rows without specular reflection are empty.
    std::vector<Rgb> diffuse;     ///< By row: radiance that does not depend on the eye.
    LobeVectors lobes;
    std::vector<VertexBrdf> materials;  ///< Of all entities, without normal and mirror direction.
    std::vector<Highlit> highlit;       ///< The rows of `specular` that are not empty.
    SourceVisibility sources;           ///< Of concentrated light.

    /// Memory. [bytes]
    std::size_t bytes() const {
        return specular.bytes() + diffuse.size() * sizeof(Rgb) + lobes.lobes.bytes() +
               highlit.size() * sizeof(Highlit) + sources.bytes();
    }
};

/// Computes the transfer vectors.
///
/// light    the smooth light.
/// sources  the concentrated light, in its current rotation.
/// errors   interrupted.
/// cost     an RGB function product per vertex.
Result<ViewTransfer> view_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                   const RenderSettings& settings, const TransferSettings& transfer,
                                   const RgbCubemapTree& light, std::span<const LightSource> sources,
                                   const Progress& progress = {});

/// Computes the radiance towards the scene's eye.
///
/// scene     with `geometry`, those of the vectors except for the eye.
/// vertices  null: all; else see store_radiance.
/// errors    interrupted; `radiance` is then unchanged.
/// cost      one inner product per selected vertex with specular reflection, with four lobes at once.
Result<Done> shade_frame(const ViewTransfer& transfer, const ShadedScene& scene,
                         const ShadingGeometry& geometry, SceneColours& radiance,
                         const VertexMask* vertices = nullptr, const Progress& progress = {});

}  // namespace haarfield
