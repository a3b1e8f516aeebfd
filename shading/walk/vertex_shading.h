#pragma once
/// The radiance of one vertex: the product of lighting, BRDF, cosine and all visibilities in one traversal.

#include "shading/walk/blocked_cones.h"
#include "shading/walk/brdf.h"
#include "shading/walk/direction_pyramid.h"
#include "shading/walk/light_pyramid.h"
#include "shading/walk/wavelet_blocks.h"
#include "shading/walk/wide_walk.h"

namespace haarfield {

/// The visibility of a vertex around all objects, as a product.
struct VisibilityProduct {
    std::span<const WeightedTrees<std::uint8_t>> trees;  ///< Around its entity and other instances.
    BlockedCones cones;                                  ///< Occluders that are evaluated exactly.
};

/// A vertex to be shaded: all factors of its product integral except the light.
struct ShadedVertex {
    const DirectionPyramid& directions;  ///< Of faces of at least two texels (asserted).
    const VertexBrdf& brdf;
    VisibilityProduct visibility;
    int depth;  ///< As in product_integral. Cosines and lobes are evaluated on the cells of this depth.
};

/// Computes the outgoing radiance of a vertex, both components in one traversal.
///
/// memory        of one thread, reused.
/// accuracy      against plain sums over the texels of the same visibility and lighting: 1e-3 for cosines.
///               For specular lobes it is 1 % of their peak where lighting is constant over 4 x 4 texels or
///               the walk stops at them. It is 3 % if a lobe is narrower than a texel (exponent 2000 about H
///               at grazing view).
/// cost          some microseconds; see product_integral. A vertex without specular reflection costs less.
/// source        as product_integral. Cosine and lobe are not stored but evaluated at the cells of the walk.
///               The mean of a cosine over a cell is the cosine of the mean direction. For the mean of a
///               lobe see lobe_mean-inl.h.
Outgoing outgoing_radiance(const LightPyramid& light, const ShadedVertex& vertex,
                           WalkMemory<std::uint8_t>& memory);

/// Computes the function whose integral is the total of outgoing_radiance: lighting times BRDF times
/// visibilities, per channel, as a function product (wavelet_blocks.h). `product` is overwritten, and its
/// memory reused. Dark faces have no block. Specular lobes below 3 % of their peak are constant over cells
/// where neither lighting nor visibility varies.
///
/// detail   null: complete. Else negligible details may be omitted: blocks below cells whose mean is kept.
/// returns  a bound on the energy of the omitted details, with the weights of `detail`.
double radiance_integrand(const LightPyramid& light, const ShadedVertex& vertex,
                          WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product,
                          const DetailWeights* detail = nullptr);

/// The results of specular_integrand next to the function product.
struct SpecularIntegrand {
    Rgb diffuse;            ///< The diffuse component of outgoing_radiance.
    double blurred_energy;  ///< A bound on the energy that the product lacks.
};

/// Computes radiance_integrand of the specular component alone, and the diffuse radiance in the same
/// traversal.
SpecularIntegrand specular_integrand(const LightPyramid& light, const ShadedVertex& vertex,
                                     WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product,
                                     const DetailWeights* detail = nullptr);

/// Computes the terms of a vertex's response to light, times visibilities, each as a channel of a function
/// product:
///     t_0 = max(0,N.w),   t_1 = lobe c,   t_2 = lobe c F(N.w),
/// without colours, so that
///     outgoing = int L [diffuse t_0 + specular (1 - metallic) t_1 + specular metallic t_2] dw.
/// A product of two terms omits t_2; in a product of three, t_2 is zero if metallic is zero.
///
/// The cosine of t_0 is constant over cells of 1/16 of a face's edge. Where visibility
/// does not vary within a cell, a lobe below 3 % of its peak is constant over the cell.
///
/// numbers  of the blocks, for faces of the size of the vertex's directions.
/// cost     as radiance_integrand; depends on diffuse and specular only by whether they are zero.
/// @{
void transfer_terms(const BlockNumbers& numbers, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                    std::vector<WaveletBlock<2>>& product);
void transfer_terms(const BlockNumbers& numbers, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                    std::vector<WaveletBlock<3>>& product);
/// @}

}  // namespace haarfield
