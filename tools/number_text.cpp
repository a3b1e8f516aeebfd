#include "tools/number_text.h"

#include <algorithm>
#include <charconv>

namespace haarfield {

std::optional<double> number_in(const Range& range, std::string_view text, bool whole) {
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || rest != end || !range.contains(value)) return std::nullopt;
    if (whole && text.find_first_not_of("-0123456789") != std::string_view::npos) return std::nullopt;
    return value;
}

std::optional<Vec3f> place_in(std::string_view text) {
    Vec3f place;
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t end = axis < 2 ? text.find(',') : text.size();
        if (end == std::string_view::npos) return std::nullopt;
        const std::optional<double> value = number_in(coordinates, text.substr(0, end));
        if (!value) return std::nullopt;
        place[axis] = static_cast<float>(*value);
        text.remove_prefix(std::min(text.size(), end + 1));
    }
    return place;
}

}  // namespace haarfield
