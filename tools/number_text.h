#pragma once
/// Parses numbers in options.

#include "fields/base/range.h"
#include "fields/base/vector.h"

#include <optional>
#include <string_view>

namespace haarfield {

/// Returns the decimal number in a text; none if it is outside the range, or the text contains anything else.
///
/// whole  also rejects fractions and exponents.
std::optional<double> number_in(const Range& range, std::string_view text, bool whole = false);

/// Returns the position in a text `X,Y,Z`; none if it is invalid. [m]
std::optional<Vec3f> place_in(std::string_view text);

}  // namespace haarfield
