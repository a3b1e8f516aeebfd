#pragma once
/// Radiance transfer for a light that changes: turned, dimmed, exchanged, mixed.

#include "shading/grouped_columns.h"
#include "shading/radiance_transfer.h"

namespace haarfield {

/// T = BRDF x visibilities x cosine per vertex, without the materials' colours. [1/sr]
struct LightTransfer {
    /// The most terms of a BRDF: diffuse, highlights, and of metals highlights times F (vertex_terms).
    static constexpr std::size_t most_terms = 3;
    using Colours = std::array<Rgb, most_terms>;  ///< What each term is multiplied with. [1/sr]

    /// Groups of neighbouring rows, and of each group one for each term: group  terms * k + t  of a block is
    /// term t of its k-th eight rows.
    std::vector<GroupedColumns> blocks;
    std::size_t terms = 2;                     ///< 3 if there are metals in the scene.
    std::vector<Colours> colours;              ///< Of the scene's materials.
    std::vector<std::uint16_t> colour_of_row;  ///< In `colours`.
    CoefficientSpectrum spectrum{};            ///< Of T, over some rows and the channels.
    float pruning_error = 0;                   ///< That the vectors were made with.

    /// Of each block but the last.
    std::size_t block_rows() const { return GroupedColumns::most_groups / terms * group_rows; }
    std::size_t bytes() const;
};

/// typical  a light like those that are to come: it tells which coefficients matter. One with more detail
///          is reproduced less exactly.
/// errors   interrupted.
/// cost     a function product per vertex.
Result<LightTransfer> light_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     const RenderSettings& settings, const TransferSettings& transfer,
                                     const DenseCoefficients& typical, const Progress& progress = {});

/// Radiance under a light (lighting.h: with the solid angle) towards the eye that the vectors were made for.
///
/// Those of the light's coefficients that matter least are left out, to an eighth of the error of pruning.
///
/// accuracy  besides pruning, rounding to bytes: 0.2 %.
/// scene, geometry  those that the vectors were made for.
/// errors  interrupted; then `radiance` is as it was.
/// cost    a multiplication and an addition for each coefficient that a vertex and the light have in common.
Result<Done> transfer_light(const LightTransfer& transfer, const ShadedScene& scene,
                            const ShadingGeometry& geometry, const DenseCoefficients& light,
                            VertexRadiance& radiance, const Progress& progress = {});

}  // namespace haarfield
