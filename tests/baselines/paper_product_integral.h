#pragma once
/// The product integral as Sun and Mukherjee 2006 print it: in double to check others with, and in float to
/// measure them against.

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "fields/wavelets/quadtree.h"

namespace haarfield::reference {

/// Section 5.1: a quadtree with orthonormal coefficients and a link to each child. p_sum is handed down by
/// the traversal, since null nodes need it too.
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

/// How the coefficients of the trees on one square are combined.
enum class PaperFold {
    recursion,  ///< Section 5.3, getproductintegral and getwaveletproduct: O(4^k) for k trees.
    table,      ///< Section 5.4, dynamic programming: O(k).
};

/// What happens to `cum` in line 9 of traverseaugtrees.
enum class PaperCumulation {
    /// Read to the letter: the parent sums of the trees that end on this square replace those of the
    /// trees that ended above, which are lost.
    as_printed,
    /// They are multiplied into them.
    corrected,
};

struct PaperVariant {
    PaperFold fold = PaperFold::table;
    PaperCumulation cumulation = PaperCumulation::corrected;
    int depth = std::numeric_limits<int>::max();  ///< Nodes at this level and below are taken as null.
};

/// 1 to 16 trees. Allocates nothing.
template <class Real>
Real paper_product_integral(std::span<const AugmentedQuadtree<Real>* const> trees,
                            const PaperVariant& variant = {});

/// The same in double.
double paper_product_integral(std::span<const Quadtree* const> trees, const PaperVariant& variant = {});

}  // namespace haarfield::reference
