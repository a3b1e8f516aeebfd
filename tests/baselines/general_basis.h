#pragma once
/// Baselines that use only the integral coefficients of the basis (Sun and Mukherjee 2006, section 3.3).
/// Feasible only for small problems.

#include "fields/wavelets/quadtree.h"
#include "tests/oracles/integral_coefficient.h"

namespace haarfield::baseline {

/// Returns all 4^levels orthonormal Haar functions of a face of 2^levels texels along an edge: the scaling
/// function, then the wavelets level by level.
std::vector<HaarBasisFunction> haar_basis(int levels);

/// Returns the coefficients of a tree of at most `levels` levels in that basis, including zeros.
std::vector<double> basis_coefficients(const Quadtree& tree, int levels);

/// Returns the sum over all tuples of basis functions of  C_(i j k ...) f_i g_j h_k ...
///
/// cost  O(M^n n) for M basis functions.
double general_basis_integral(std::span<const Quadtree* const> trees, int levels);

/// Products of two functions at a time, with all M^3 third-order integral coefficients.
class RecursiveGeneralBasis {
public:
    /// memory  4 M^3 bytes.
    /// cost    M^3 integral coefficients.
    explicit RecursiveGeneralBasis(int levels);

    /// Returns int f_1 f_2 ... f_k, k >= 2, for functions given by basis_coefficients.
    ///
    /// cost  O(M^3 k).
    float operator()(std::span<const std::vector<float>> functions) const;

private:
    std::size_t count_;
    std::vector<float> coefficients_;  ///< Indexed by (i * count_ + j) * count_ + k.
};

}  // namespace haarfield::baseline
