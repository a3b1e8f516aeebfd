#pragma once
/// The integral of a product of any number of quadtrees, one square at a time: the oracle and baseline of the
/// wide walk of shading/walk/product_integral.h.

#include "shading/walk/wide_tree.h"

namespace haarfield::reference {

/// Returns I = int f_1 f_2 ... f_k dA over the unit square of one face.
///
/// factors   1 <= k <= 64 (asserted).
/// depth     nodes at level >= depth are ignored: coarser and faster (Figure 4). >= 0.
/// returns   I, in the product of the factors' units.
/// accuracy  exact for the stored amplitudes up to rounding: 1e-6 of the product of the factors' L2 norms.
/// cost      O(sum of nodes visited): squares on which at least two factors vary and none is zero.
/// source    Sun and Mukherjee 2006, section 5.1. The truncated functions are piecewise constant. If at most
///           one factor varies on a square, the mean of the product is the product of the means. If a factor
///           is constantly zero, nothing below contributes.
float scalar_product_integral(std::span<const Quadtree* const> factors, int depth = full_depth);

/// Returns I = int light f_1 ... f_k dA per channel, in one walk. k >= 0.
Rgb scalar_product_integral(const RgbQuadtree& light, std::span<const Quadtree* const> factors,
                            int depth = full_depth);

/// Returns the integral over the sphere: the sum over the six faces of the lighting (which contains the solid
/// angle) and factors.
Rgb scalar_product_integral(const RgbCubemapTree& light, std::span<const CubemapTree* const> factors,
                            int depth = full_depth);

}  // namespace haarfield::reference
