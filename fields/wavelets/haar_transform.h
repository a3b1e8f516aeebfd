#pragma once
/// Texels to quadtrees and back: the non-standard Haar transform with non-linear approximation.

#include "fields/wavelets/quadtree.h"

namespace haarfield {

/// Which wavelets are kept. Both rules may act together; the mean is always kept.
struct Truncation {
    int coefficients = 0;            ///< At most so many wavelets a face, largest first; 0: no limit.
    float relative_l2_error = 0.0f;  ///< Drop the smallest wavelets while the L2 error stays below this
                                     ///< fraction of the L2 norm of f; 0: drop only exact zeros.
};

/// The tree of a face.
///
/// texels      size * size values, row by row; size is_face_size (asserted).
/// truncation  by magnitude in the orthonormal basis, which is optimal in L2; for Rgb the magnitude is
///             the Euclidean one over the three channels. Ties go to the coarser level, then to the
///             smaller index. Ancestors of a kept wavelet exist, with zeros for what was dropped.
/// accuracy    exact up to rounding (1e-6 of the largest texel) without truncation.
/// cost        O(texels).
template <class Value>
BasicQuadtree<Value> haar_quadtree(std::span<const Value> texels, int size,
                                   const Truncation& truncation = {});

/// The inverse: means over size * size texels, row by row. Nodes below the texels are averaged out.
template <class Value>
std::vector<Value> quadtree_texels(const BasicQuadtree<Value>& tree, int size);

/// sum_i weights[i] * trees[i], exactly, as a tree over the union of their nodes.
///
/// trees, weights  of one length, 1 to 16 (asserted).
template <class Value>
BasicQuadtree<Value> weighted_sum(std::span<const BasicQuadtree<Value>* const> trees,
                                  std::span<const float> weights);

/// All six faces; texels face by face, 6 * size * size values.
template <class Value>
BasicCubemapTree<Value> haar_cubemap(std::span<const Value> texels, int size,
                                     const Truncation& truncation = {});

}  // namespace haarfield
