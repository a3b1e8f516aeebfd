#include "fields/model/model_format.h"

#include "fields/model/mesh2_file.h"

#include <cstdint>
#include <cstring>

namespace haarfield {
namespace {

constexpr std::string_view blanks = " \t\r\n\f\v";

bool is_blank(char c) {
    return blanks.find(c) != blanks.npos;
}

std::string_view without_blanks(std::string_view text) {
    const std::size_t first = text.find_first_not_of(blanks);
    return first == text.npos ? std::string_view() : text.substr(first);
}

std::string_view without_byte_order_mark(std::string_view text) {
    constexpr std::string_view mark = "\xef\xbb\xbf";
    return text.starts_with(mark) ? text.substr(mark.size()) : text;
}

/// Tests the length of a binary STL file, which has no signature: 80 arbitrary bytes, the number of
/// triangles, and 50 bytes for each.
bool is_binary_stl(std::string_view bytes, bool may_be_longer) {
    constexpr std::size_t head = 84, triangle = 50;
    if (bytes.size() < head) return false;
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    const std::size_t wanted = head + triangle * std::size_t(count);
    return may_be_longer ? bytes.size() >= wanted : bytes.size() == wanted;
}

/// Returns the first bytes of a text, enough for the words that identify its format. The remaining bytes of
/// large files, such as sparse ones, are not read.
std::string_view first_bytes(std::string_view text) {
    return text.substr(0, std::size_t{1} << 16);
}

/// Tests for the word `solid`, and `facet` or the end.
bool is_text_stl(std::string_view text) {
    text = first_bytes(text);
    return text.starts_with("solid") &&
           (text.find("facet") != text.npos || text.find("endsolid") != text.npos);
}

/// Tests whether the first word after comment lines ends in OFF.
bool is_off(std::string_view text) {
    text = first_bytes(text);
    while (true) {
        text = without_blanks(text);
        if (!text.starts_with('#')) break;
        text.remove_prefix(std::min(text.find('\n'), text.size()));
    }
    const std::string_view word = text.substr(0, text.find_first_of(blanks));
    return word.size() <= 8 && word.ends_with("OFF");
}

/// Tests for a line that begins with `v` and a number.
bool is_obj(std::string_view text) {
    for (std::size_t at = text.find('v'); at != text.npos; at = text.find('v', at + 1)) {
        std::size_t begin = at;
        while (begin > 0 && (text[begin - 1] == ' ' || text[begin - 1] == '\t')) --begin;
        if (begin > 0 && text[begin - 1] != '\n' && text[begin - 1] != '\r') continue;
        if (at + 1 >= text.size() || !is_blank(text[at + 1])) continue;
        const std::string_view rest = without_blanks(text.substr(at + 1, 64));
        if (!rest.empty() && std::string_view("+-.0123456789nNiI").find(rest[0]) != std::string_view::npos)
            return true;
    }
    return false;
}

bool is_povray_ending(std::string_view ending) {
    return ending == ".inc" || ending == ".pov" || ending == ".mesh2";
}

}  // namespace

std::optional<ModelFormat> model_format(std::string_view bytes, std::string_view ending) {
    if (bytes.starts_with("glTF")) return ModelFormat::glb;
    if (bytes.starts_with("ply\n") || bytes.starts_with("ply\r")) return ModelFormat::ply;
    if (is_binary_stl(bytes, /*may_be_longer=*/false)) return ModelFormat::stl;
    const bool is_text = first_bytes(bytes).find('\0') == bytes.npos;
    const std::string_view text = without_blanks(without_byte_order_mark(bytes));
    if (is_text_stl(text)) return ModelFormat::stl;
    if (text.starts_with('{')) return ModelFormat::gltf;
    if (is_off(text)) return ModelFormat::off;
    const bool has_mesh2 = is_text && mentions_mesh2(bytes);
    if (is_povray_ending(ending) && has_mesh2) return ModelFormat::mesh2;
    if (is_text && is_obj(bytes)) return ModelFormat::obj;
    if (has_mesh2) return ModelFormat::mesh2;
    if (ending == ".stl" && is_binary_stl(bytes, /*may_be_longer=*/true)) return ModelFormat::stl;
    return {};
}

}  // namespace haarfield
