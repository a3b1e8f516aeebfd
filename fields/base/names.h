#pragma once
/// Names of files and of objects in them: plain, unique, quoted.

#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <string_view>

namespace haarfield {

/// True for an ASCII letter, a digit, `_`, `-` or `.`: the characters that are valid in names of files and of
/// POV-Ray scenes.
bool is_plain(char c);

/// Replaces each character that is not plain by `_`.
std::string plain_name(std::string_view name);

/// Returns the extension of a file name in lower case, including the dot.
std::string lower_ending(const std::filesystem::path& file);

/// Returns `name`, or if `taken` contains it, the first of `name_2`, `name_3` ... that `taken` does not
/// contain. Adds the result to `taken`.
///
/// before, after  the text around the number.
std::string unique_name(const std::string& name, std::set<std::string>& taken, std::string_view before = "_",
                        std::string_view after = "");

/// Returns `"a", "b" and 3 more`: quotes at most `most` names.
std::string quoted_list(std::span<const std::string> names, std::size_t most = SIZE_MAX);

}  // namespace haarfield
