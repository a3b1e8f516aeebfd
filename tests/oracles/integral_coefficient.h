#pragma once
/// The generalized Haar integral coefficient theorem (Sun and Mukherjee 2006, section 4.2).

#include <cstdint>
#include <span>

namespace haarfield {

/// One orthonormal 2-D Haar basis function on the unit square.
struct HaarBasisFunction {
    enum class Kind : std::uint8_t { scaling, along_x, along_y, diagonal };
    Kind kind = Kind::scaling;
    int level = 0;               ///< The support is a square of side 2^-level.
    std::uint32_t x = 0, y = 0;  ///< Index of the square: 0 <= x, y < 2^level.
};

/// Returns C = int b_1 b_2 ... b_k dA over the unit square.
///
/// Non-zero iff the supports are nested and, among the functions of the finest level, the numbers of the
/// three wavelet kinds have the same parity. Then it is +-2^(sum of levels - 2 * finest level), with the sign
/// of the product of the quadrant signs of the coarser wavelets on the finest square.
///
/// functions  k >= 1 (asserted).
/// accuracy   exact.
/// cost       O(k).
double integral_coefficient(std::span<const HaarBasisFunction> functions);

}  // namespace haarfield
