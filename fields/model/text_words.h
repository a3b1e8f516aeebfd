#pragma once
/// Lines and words of text files.

#include <algorithm>
#include <string_view>

namespace haarfield {

inline constexpr std::string_view blanks = " \t\r\n\v\f";  ///< Characters that separate words.

/// Removes the first word from a text; empty at the end.
inline std::string_view next_word(std::string_view& text) {
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    const std::string_view word = text.substr(0, text.find_first_of(blanks));
    text.remove_prefix(word.size());
    return word;
}

/// Removes the first line from a text, without its line break.
inline std::string_view next_line(std::string_view& text) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

}  // namespace haarfield
