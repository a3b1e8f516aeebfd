#pragma once
/// Concentrated light beside radiance transfer: what vectors give is smooth, and shadow rays add the rest.

#include "shading/bake/source_light.h"
#include "shading/transfer/radiance_transfer.h"

namespace haarfield {

/// Adds to each row's radiance what the lights shed on its vertex towards the scene's eye. The geometry's
/// rays must be placed as the scene is.
///
/// wanted   null: all rows; else those of its vertices.
/// diffuse  by row, to which the diffuse part is added, too; or none.
/// errors  interrupted; then the radiance is of no use.
/// cost    see add_source_light.
Result<Done> add_source_rows(const ShadedScene& scene, const ShadingGeometry& geometry,
                             std::span<const DirectionalLight> lights, std::span<Rgb> by_row,
                             const VertexMask* wanted = nullptr, const Progress& progress = {},
                             std::span<Rgb> diffuse = {});

/// What vertices see of each source, for an eye that moves: visibility is found once.
struct SourceSights {
    /// The part of a source that a vertex sees, as one light.
    struct Sight {
        std::uint32_t row;
        DirectionalLight light;
    };
    std::vector<std::vector<Sight>> blocks;  ///< By 64 rows; of rows that have highlights, in their order.

    std::size_t bytes() const;  ///< Memory. [bytes]
};

/// Finds the sights, and adds to `diffuse`, by row, what the lights shed by the diffuse terms.
///
/// errors  interrupted.
Result<SourceSights> source_sights(const ShadedScene& scene, const ShadingGeometry& geometry,
                                   std::span<const LightSource> sources, std::span<Rgb> diffuse,
                                   const Progress& progress = {});

/// Adds the highlights of what is seen of the sources, towards the scene's eye.
///
/// accuracy  exact but for taking the seen part of each source as one direction: lobes that are not much
///           wider than a source are somewhat sharper than they should be.
/// cost      some 50 ns a sight.
Result<Done> add_source_highlights(const SourceSights& sights, const ShadedScene& scene,
                                   const ShadingGeometry& geometry, std::span<Rgb> by_row,
                                   const VertexMask* wanted = nullptr, const Progress& progress = {});

}  // namespace haarfield
