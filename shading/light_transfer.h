#pragma once
/// Radiance transfer for a light that changes: turned, dimmed, exchanged, mixed.

#include "shading/radiance_transfer.h"
#include "shading/sparse_columns.h"

namespace haarfield {

/// T = BRDF x visibilities x cosine per vertex. [1/sr]
///
/// Diffuse and specular vectors are kept apart, one value a coefficient: their indices together are at most
/// twice as many as those of one RGB vector for both, which has three values a coefficient.
struct LightTransfer {
    static constexpr std::size_t block_rows = 512;

    /// Rows 2 k and 2 k + 1 of a block are the diffuse and specular vectors of its k-th row, without the
    /// materials' colours. Empty where there are none.
    std::vector<SparseColumns> blocks;
    CoefficientSpectrum spectrum{};  ///< Of T, over some rows and the channels.
    float pruning_error = 0;         ///< That the vectors were made with.

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
/// scene  the one that the vectors were made for.
/// cost   a multiplication and an addition for each coefficient that a vertex and the light have in common.
void transfer_light(const LightTransfer& transfer, const ShadedScene& scene, const DenseCoefficients& light,
                    VertexRadiance& radiance);

}  // namespace haarfield
