#pragma once
/// Parses durations and sizes of the command line.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace haarfield {

/// Returns the duration in `90s`, `15min`, `36h` or `30d`: a positive number, possibly with a fraction, up to
/// 1e6 days.
std::optional<std::chrono::seconds> duration_of(std::string_view text);

/// Returns the size in `500kB`, `20MB`, `1.5GB` or `2TB`, with decimal units: a positive number, possibly
/// with a fraction, up to 1e6 TB. [bytes]
std::optional<std::uint64_t> byte_count_of(std::string_view text);

}  // namespace haarfield
