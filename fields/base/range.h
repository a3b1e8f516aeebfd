#pragma once
/// Ranges of allowed numbers.

#include <string>

namespace haarfield {

/// An interval of finite numbers.
struct Range {
    double lowest = 0, highest = 0;
    bool without_lowest = false, without_highest = false;

    /// Tests whether the range contains a number, both exactly and rounded to float, so that the stored value
    /// is in the range, too. False for NaN and infinities.
    bool contains(double value) const;

    std::string text() const;  ///< For example `(0, 1]`.
};

/// Allowed coordinates. Beyond them, float steps are 6 cm or more. [m]
inline constexpr Range coordinates{-1e6, 1e6};

}  // namespace haarfield
