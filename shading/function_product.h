#pragma once
/// The product of any number of functions, again as a tree.

#include "shading/product_integral.h"

namespace haarfield {

/// T = f_1 f_2 ... f_k on one face, untruncated: exact for the stored amplitudes.
///
/// factors, depth   as in product_integral.
/// cost             O(nodes of the union of the factors' trees).
/// source           Sun and Mukherjee 2006, section 5.2. Means of the product are written top-down to
///                  the leaves of the union of the trees, then transformed bottom-up; this needs no
///                  scatter to the ancestors of every node.
Quadtree function_product(std::span<const Quadtree* const> factors, int depth = full_depth);
RgbQuadtree function_product(const RgbQuadtree& light, std::span<const Quadtree* const> factors,
                             int depth = full_depth);

/// <f, g> = int f g dA by orthonormal coefficients: what a radiance transfer vector costs per frame.
float inner_product(const Quadtree& f, const Quadtree& g);
Rgb inner_product(const RgbQuadtree& f, const Quadtree& g);

}  // namespace haarfield
