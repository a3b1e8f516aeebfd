#pragma once
/// Prints to stdout and stderr without exceptions.

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

namespace haarfield {

/// Writes text to stdout or stderr. A closed pipe or a full disk sets the stream's error indicator, which
/// `main` reports for stdout; fmt::print would throw an exception.
inline void print_text(std::FILE* stream, std::string_view text) {
    std::fwrite(text.data(), 1, text.size(), stream);
}

/// Formats values and prints them.
template <class... Values>
void print(std::FILE* stream, fmt::format_string<Values...> format, Values&&... values) {
    print_text(stream, fmt::format(format, std::forward<Values>(values)...));
}

}  // namespace haarfield
