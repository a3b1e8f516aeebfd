#pragma once
/// Conversion of texels to quadtrees and back: the non-standard Haar transform with non-linear approximation.

#include "fields/wavelets/quadtree.h"

namespace haarfield {

/// The rule that selects wavelets to keep. Both limits may be set. The mean is always kept.
struct Truncation {
    int coefficients = 0;  ///< At most this number of wavelets per face, largest first; 0: no limit.
    float relative_l2_error = 0.0f;  ///< Drop the smallest wavelets while the L2 error stays below this
                                     ///< fraction of the L2 norm of f; 0: drop only exact zeros.
};

/// Transforms the texels of a face into a quadtree.
///
/// texels      size * size values in row-major order; size is_face_size (asserted).
/// truncation  by magnitude in the orthonormal basis, which is optimal in L2. The magnitude of an Rgb is its
///             Euclidean norm. Ties go to the coarser level, then to the smaller index. Ancestors of a kept
///             wavelet exist, with zeros for dropped wavelets.
/// accuracy    exact up to rounding (1e-6 of the largest texel) without truncation.
/// cost        O(texels).
template <class Value>
BasicQuadtree<Value> haar_quadtree(std::span<const Value> texels, int size,
                                   const Truncation& truncation = {});

/// The inverse of haar_quadtree: means over size * size texels in row-major order. Nodes below the texels are
/// averaged out.
template <class Value>
std::vector<Value> quadtree_texels(const BasicQuadtree<Value>& tree, int size);

/// Returns sum_i weights[i] * trees[i], up to rounding, as a tree over the union of their nodes.
///
/// trees, weights  equally many, 1 to 16 (asserted).
template <class Value>
BasicQuadtree<Value> weighted_sum(std::span<const BasicQuadtree<Value>* const> trees,
                                  std::span<const float> weights);

/// Transforms all six faces. texels: 6 * size * size values, face by face.
template <class Value>
BasicCubemapTree<Value> haar_cubemap(std::span<const Value> texels, int size,
                                     const Truncation& truncation = {});

}  // namespace haarfield
