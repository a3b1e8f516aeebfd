#pragma once
/// Radiance transfer for a light that changes: turned, dimmed, exchanged, mixed.

#include "shading/radiance_transfer.h"
#include "shading/sparse_products.h"

namespace haarfield {

/// T = BRDF x visibilities x cosine per vertex. [1/sr]
///
/// Diffuse and specular vectors are kept apart, one value a coefficient: their indices together are at most
/// twice as many as those of one RGB vector for both, which has three values a coefficient.
struct LightTransfer {
    SparseVectorBlocks diffuse,
        specular;  ///< Without the materials' colours. Empty rows where there is none.

    std::size_t bytes() const { return diffuse.bytes() + specular.bytes(); }
};

/// typical  a light like those that are to come: it tells which coefficients matter. One with more detail
///          is reproduced less exactly.
/// errors   interrupted.
/// cost     a function product per vertex and term.
Result<LightTransfer> light_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     const RenderSettings& settings, const TransferSettings& transfer,
                                     const DenseCoefficients& typical, const Progress& progress = {});

/// Radiance under a light (lighting.h: with the solid angle) towards the eye that the vectors were made for.
///
/// scene  the one that the vectors were made for.
/// cost   one inner product per vertex and term, bound by memory.
void transfer_light(const LightTransfer& transfer, const ShadedScene& scene, const DenseCoefficients& light,
                    VertexRadiance& radiance);

}  // namespace haarfield
