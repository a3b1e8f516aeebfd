#pragma once
/// The baseline of products of two functions at a time, each again a tree of Haar wavelets: Ng, Ramamoorthi
/// and Hanrahan 2004, applied repeatedly, as in Zhou et al. 2005.

#include "fields/wavelets/quadtree.h"

namespace haarfield::baseline {

/// A quadtree in depth-first order with a link to each child, so that appending is cheap.
struct LinkedQuadtree {
    struct Node {
        std::array<float, 3> wavelet;       ///< Amplitudes, as in BasicQuadtree.
        std::array<std::int32_t, 4> child;  ///< By quadrant, or no_node.
    };
    float scaling = 0;
    std::vector<Node> nodes;  ///< Root first; empty if the function is constant.
};

LinkedQuadtree linked_quadtree(const Quadtree& tree);

/// Computes the tree of f g, which replaces `product`. It has a node wherever one factor has a node and the
/// other is not constantly zero.
void pairwise_product(const LinkedQuadtree& f, const LinkedQuadtree& g, LinkedQuadtree& product);

/// Computes products of several functions. Keeps its buffers, so that repeated use allocates nothing.
class RecursivePairwiseProduct {
public:
    /// Returns int light f_1 ... f_k dA over one face: (f_1 f_2) f_3 ..., and its inner product with light.
    /// Nothing is truncated in between, because the coefficients that a later factor needs are not known. k
    /// >= 1.
    Rgb operator()(const RgbQuadtree& light, std::span<const LinkedQuadtree* const> factors);

private:
    LinkedQuadtree product_, next_;
};

}  // namespace haarfield::baseline
