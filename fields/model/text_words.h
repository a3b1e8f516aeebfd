#pragma once
/// Text files of meshes by lines and words.

#include <algorithm>
#include <string_view>

namespace haarfield {

inline constexpr std::string_view blanks = " \t\r\n\v\f";  ///< What stands between words.

/// Takes the first word off a text; empty at its end.
inline std::string_view next_word(std::string_view& text) {
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    const std::string_view word = text.substr(0, text.find_first_of(blanks));
    text.remove_prefix(word.size());
    return word;
}

/// Takes the first line off a text, without its end.
inline std::string_view next_line(std::string_view& text) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

}  // namespace haarfield
