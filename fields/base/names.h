#pragma once
/// Names of files and of things in them: made plain, told apart, listed.

#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <string_view>

namespace haarfield {

/// A letter of ASCII, a digit, `_`, `-` or `.`: what files and POV-Ray's scenes take in a name.
bool is_plain(char c);

/// The name with `_` for all that is not plain.
std::string plain_name(std::string_view name);

/// A file's ending in lower case, with its point.
std::string lower_ending(const std::filesystem::path& file);

/// A name unlike those that are taken: numbered from 2 on, `name_2`, where it has to be. It is then
/// taken, too.
///
/// before, after  what stands round the number.
std::string unique_name(const std::string& name, std::set<std::string>& taken, std::string_view before = "_",
                        std::string_view after = "");

/// `"a", "b" and 3 more`: at most so many of them.
std::string quoted_list(std::span<const std::string> names, std::size_t most = SIZE_MAX);

}  // namespace haarfield
