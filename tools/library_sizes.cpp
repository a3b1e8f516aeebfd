#include "tools/library_sizes.h"

#include <array>
#include <charconv>
#include <utility>

namespace haarfield {
namespace {

using Units = std::array<std::pair<std::string_view, double>, 4>;

constexpr double most_units = 1e6;  // of the largest unit

/// Returns a positive number with one of the units, converted to the smallest unit; nothing for other texts.
std::optional<double> measured(std::string_view text, const Units& units) {
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc()) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    for (const auto& [name, size] : units)
        if (text == name) {
            const double value = number * size;
            if (value > 0 && value <= most_units * units.back().second) return value;
        }
    return std::nullopt;
}

}  // namespace

std::optional<std::chrono::seconds> duration_of(std::string_view text) {
    const auto seconds = measured(text, {{{"s", 1}, {"min", 60}, {"h", 3600}, {"d", 86400}}});
    if (!seconds) return std::nullopt;
    return std::chrono::seconds(static_cast<std::int64_t>(*seconds));
}

std::optional<std::uint64_t> byte_count_of(std::string_view text) {
    const auto bytes = measured(text, {{{"kB", 1e3}, {"MB", 1e6}, {"GB", 1e9}, {"TB", 1e12}}});
    if (!bytes) return std::nullopt;
    return static_cast<std::uint64_t>(*bytes);
}

}  // namespace haarfield
