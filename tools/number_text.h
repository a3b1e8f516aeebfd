#pragma once
/// Numbers that users type.

#include "fields/base/range.h"
#include "fields/base/vector.h"

#include <optional>
#include <string_view>

namespace haarfield {

/// A decimal number of a range; none if the text is anything else, or goes on after it.
///
/// whole  refuses fractions and exponents, too.
std::optional<double> number_in(const Range& range, std::string_view text, bool whole = false);

/// A place, from its three coordinates: `X,Y,Z`. [m]
std::optional<Vec3f> place_in(std::string_view text);

}  // namespace haarfield
