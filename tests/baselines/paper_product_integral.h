#pragma once
/// The product integral as printed in Sun and Mukherjee 2006: in double as an oracle, and in float as a
/// baseline.

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "fields/wavelets/quadtree.h"

namespace haarfield::reference {

/// Section 5.1: a quadtree with orthonormal coefficients and a link to each child. The traversal passes p_sum
/// down, because null nodes need it, too.
template <class Real>
struct AugmentedQuadtree {
    struct Node {
        std::array<Real, 3> wavelet;
        std::array<std::int32_t, 4> child;  ///< By quadrant; no_node: null.
    };
    Real scaling = 0;
    std::vector<Node> nodes;  ///< Root first; empty if the function is constant.
};

template <class Real>
AugmentedQuadtree<Real> augmented_quadtree(const Quadtree& tree);

/// The method that combines the coefficients of the trees on one square.
enum class PaperFold {
    recursion,  ///< Section 5.3, getproductintegral and getwaveletproduct: O(4^k) for k trees.
    table,      ///< Section 5.4, dynamic programming: O(k).
};

/// The update of `cum` in line 9 of traverseaugtrees.
enum class PaperCumulation {
    /// Literally: the parent sums of the trees that end on this square replace those of the trees that ended
    /// above, which are lost.
    as_printed,
    /// The new sums multiply the earlier ones.
    corrected,
};

struct PaperVariant {
    PaperFold fold = PaperFold::table;
    PaperCumulation cumulation = PaperCumulation::corrected;
    int depth = std::numeric_limits<int>::max();  ///< Nodes at this level and below are treated as null.
};

/// Computes the product integral of 1 to 16 trees. Allocates nothing.
template <class Real>
Real paper_product_integral(std::span<const AugmentedQuadtree<Real>* const> trees,
                            const PaperVariant& variant = {});

/// The product integral in double.
double paper_product_integral(std::span<const Quadtree* const> trees, const PaperVariant& variant = {});

}  // namespace haarfield::reference
