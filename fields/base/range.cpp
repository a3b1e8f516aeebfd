#include "fields/base/range.h"

#include <fmt/format.h>

#include <cmath>

namespace haarfield {

bool Range::contains(double value) const {
    const auto holds = [this](auto number, auto low, auto high) {
        return (without_lowest ? number > low : number >= low) &&
               (without_highest ? number < high : number <= high);
    };
    return std::isfinite(value) && holds(value, lowest, highest) &&
           holds(static_cast<float>(value), static_cast<float>(lowest), static_cast<float>(highest));
}

std::string Range::text() const {
    return fmt::format("{}{}, {}{}", without_lowest ? '(' : '[', lowest, highest,
                       without_highest ? ')' : ']');
}

}  // namespace haarfield
