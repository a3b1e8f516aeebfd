#pragma once
/// Radiance transfer for a light that changes: turned, dimmed, exchanged, mixed.

#include "shading/radiance_transfer.h"
#include "shading/sparse_columns.h"

namespace haarfield {

/// T = BRDF x visibilities x cosine per vertex. [1/sr]
///
/// The terms' vectors are kept apart, one value a coefficient: the indices of two together are at most twice
/// as many as those of one RGB vector for both, which has three values a coefficient.
struct LightTransfer {
    static constexpr std::size_t block_rows = 512;

    /// Row  terms * k + t  of a block is term t of its k-th row: 0 diffuse, 1 highlights, 2 highlights times
    /// F (VertexBrdf), of metals. Without the materials' colours; empty where there is none.
    std::vector<SparseColumns> blocks;
    std::size_t terms = 2;           ///< 3 if there are metals in the scene.
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
/// scene, geometry  those that the vectors were made for.
/// errors  interrupted; then `radiance` is as it was.
/// cost    a multiplication and an addition for each coefficient that a vertex and the light have in common.
Result<Done> transfer_light(const LightTransfer& transfer, const ShadedScene& scene,
                            const ShadingGeometry& geometry, const DenseCoefficients& light,
                            VertexRadiance& radiance, const Progress& progress = {});

}  // namespace haarfield
