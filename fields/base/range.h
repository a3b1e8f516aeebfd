#pragma once
/// Which numbers are allowed where one is read.

#include <string>

namespace haarfield {

/// An interval of finite numbers.
struct Range {
    double lowest = 0, highest = 0;
    bool without_lowest = false, without_highest = false;

    /// Whether it holds a number, as it is and as the nearest float: what is stored is in the range, too. NaN
    /// and infinities are in none.
    bool contains(double value) const;

    std::string text() const;  ///< Such as `(0, 1]`.
};

/// Coordinates of places. Beyond, float steps are 6 cm and more. [m]
inline constexpr Range coordinates{-1e6, 1e6};

}  // namespace haarfield
