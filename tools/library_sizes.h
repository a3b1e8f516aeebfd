#pragma once
/// Lengths of time and sizes, as people type them.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace haarfield {

/// `90s`, `15min`, `36h` or `30d`: a positive number, which may have a fraction; up to 1e6 days.
std::optional<std::chrono::seconds> duration_of(std::string_view text);

/// `500kB`, `20MB`, `1.5GB` or `2TB`, decimal; likewise, up to 1e6 TB. [bytes]
std::optional<std::uint64_t> byte_count_of(std::string_view text);

}  // namespace haarfield
