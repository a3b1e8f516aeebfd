#pragma once
/// The baselines that know nothing of the basis but its integral coefficients (Sun and Mukherjee 2006,
/// section 3.3). Only small cases end within a lifetime.

#include "fields/wavelets/quadtree.h"
#include "tests/oracles/integral_coefficient.h"

namespace haarfield::baseline {

/// All 4^levels orthonormal Haar functions of a face of 2^levels texels along an edge: the scaling function,
/// then the wavelets level by level.
std::vector<HaarBasisFunction> haar_basis(int levels);

/// A tree of at most `levels` levels in that basis, zeros included.
std::vector<double> basis_coefficients(const Quadtree& tree, int levels);

/// sum over all tuples of basis functions of  C_(i j k ...) f_i g_j h_k ...
///
/// cost  O(M^n n), M the basis functions.
double general_basis_integral(std::span<const Quadtree* const> trees, int levels);

/// Two functions at a time, by all M^3 third-order integral coefficients.
class RecursiveGeneralBasis {
public:
    /// memory  4 M^3 bytes.
    /// cost    M^3 integral coefficients.
    explicit RecursiveGeneralBasis(int levels);

    /// int f_1 f_2 ... f_k, k >= 2, by basis_coefficients.
    ///
    /// cost  O(M^3 k).
    float operator()(std::span<const std::vector<float>> functions) const;

private:
    std::size_t count_;
    std::vector<float> coefficients_;  ///< By (i * count_ + j) * count_ + k.
};

}  // namespace haarfield::baseline
