#pragma once
/// The baseline of products of two functions at a time, each again a tree of Haar wavelets: Ng, Ramamoorthi
/// and Hanrahan 2004, applied as often as there are functions, as Zhou et al. 2005 do.

#include "fields/wavelets/quadtree.h"

namespace haarfield::baseline {

/// A quadtree depth first, with a link to each child: what is cheap to append to.
struct LinkedQuadtree {
    struct Node {
        std::array<float, 3> wavelet;       ///< Amplitudes, as BasicQuadtree's.
        std::array<std::int32_t, 4> child;  ///< By quadrant, or no_node.
    };
    float scaling = 0;
    std::vector<Node> nodes;  ///< Root first; empty if the function is constant.
};

LinkedQuadtree linked_quadtree(const Quadtree& tree);

/// The tree of f g, in place of what `product` was. It has a node wherever one of its factors has, and the
/// other is not constantly zero.
void pairwise_product(const LinkedQuadtree& f, const LinkedQuadtree& g, LinkedQuadtree& product);

/// Keeps its memory: repeated use allocates nothing.
class RecursivePairwiseProduct {
public:
    /// int light f_1 ... f_k dA over one face: (f_1 f_2) f_3 ..., and the inner product of that with light.
    /// Nothing is dropped on the way, since what a later factor needs is not known. k >= 1.
    Rgb operator()(const RgbQuadtree& light, std::span<const LinkedQuadtree* const> factors);

private:
    LinkedQuadtree product_, next_;
};

}  // namespace haarfield::baseline
