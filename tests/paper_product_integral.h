#pragma once
/// The product integral as Sun and Mukherjee 2006 compute it, in double: the same number by other means.

#include <span>

#include "fields/quadtree.h"

namespace haarfield::reference {

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

double paper_product_integral(std::span<const Quadtree* const> factors, PaperFold fold,
                              PaperCumulation cumulation = PaperCumulation::corrected);

}  // namespace haarfield::reference
