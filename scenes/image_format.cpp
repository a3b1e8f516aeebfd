#include "scenes/image_format.h"

#include <array>
#include <cstdint>
#include <utility>

namespace haarfield {
namespace {

using namespace std::string_view_literals;

constexpr std::array<std::pair<std::string_view, const char*>, 10> beginnings{{
    {"\x76\x2f\x31\x01"sv, "openexr"},
    {"#?RADIANCE"sv, "hdr"},
    {"#?RGBE"sv, "hdr"},
    {"\x89PNG\r\n\x1a\n"sv, "png"},
    {"\xff\xd8\xff"sv, "jpeg"},
    {"II*\0"sv, "tiff"},
    {"MM\0*"sv, "tiff"},
    {"II+\0\x08\0"sv, "tiff"},  // Files larger than 4 GB.
    {"MM\0+\0\x08"sv, "tiff"},
    {"BM"sv, "bmp"},
}};

bool is_webp(std::string_view bytes) {
    return bytes.size() >= 12 && bytes.starts_with("RIFF") && bytes.substr(8, 4) == "WEBP";
}

bool is_targa(std::string_view bytes) {
    constexpr std::size_t head = 18;
    if (bytes.size() < head) return false;
    const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(bytes[at]); };
    const auto number = [&](std::size_t at) { return byte(at) + 256 * byte(at + 1); };
    const int kind = byte(2), depth = byte(16);
    const bool has_map = byte(1) == 1, wants_map = kind == 1 || kind == 9;
    const bool is_known = wants_map || kind == 2 || kind == 3 || kind == 10 || kind == 11;
    return is_known && byte(1) <= 1 && (has_map || !wants_map) && number(12) > 0 && number(14) > 0 &&
           (depth == 8 || depth == 15 || depth == 16 || depth == 24 || depth == 32);
}

}  // namespace

const char* image_plugin(std::string_view bytes) {
    for (const auto& [beginning, plugin] : beginnings)
        if (bytes.starts_with(beginning)) return plugin;
    return is_webp(bytes) ? "webp" : is_targa(bytes) ? "targa" : nullptr;
}

}  // namespace haarfield
