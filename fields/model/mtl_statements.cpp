#include "fields/model/mtl_statements.h"

#include <algorithm>
#include <string_view>

namespace haarfield {
namespace {

/// Returns the beginning of the first line whose first word is `newmtl`, or the end of the text.
std::size_t first_material(std::string_view mtl) {
    constexpr std::string_view word = "newmtl", blanks = " \t", line_ends = "\r\n";
    for (std::size_t line = 0; line < mtl.size();) {
        const std::size_t begin = std::min(mtl.find_first_not_of(blanks, line), mtl.size());
        const std::string_view rest = mtl.substr(begin);
        const bool ends_there =
            rest.size() == word.size() ||
            (rest.size() > word.size() &&
             std::string_view(" \t\r\n").find(rest[word.size()]) != std::string_view::npos);
        if (rest.starts_with(word) && ends_there) return line;
        const std::size_t end = mtl.find_first_of(line_ends, begin);
        line = end == std::string_view::npos ? mtl.size() : end + 1;
    }
    return mtl.size();
}

}  // namespace

std::string without_leading_statements(std::string mtl) {
    const auto end = mtl.begin() + static_cast<std::ptrdiff_t>(first_material(mtl));
    std::replace_if(
        mtl.begin(), end, [](char c) { return c != '\n' && c != '\r'; }, ' ');
    return mtl;
}

}  // namespace haarfield
