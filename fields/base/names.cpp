#include "fields/base/names.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

bool is_plain(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
}

std::string plain_name(std::string_view name) {
    std::string plain(name);
    std::ranges::replace_if(
        plain, [](char c) { return !is_plain(c); }, '_');
    return plain;
}

std::string lower_ending(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    std::ranges::transform(ending, ending.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    return ending;
}

std::string unique_name(const std::string& name, std::set<std::string>& taken, std::string_view before,
                        std::string_view after) {
    std::string made = name;
    for (int k = 2; !taken.insert(made).second; ++k) made = fmt::format("{}{}{}{}", name, before, k, after);
    return made;
}

std::string quoted_list(std::span<const std::string> names, std::size_t most) {
    std::string list;
    for (const std::string& name : names.first(std::min(most, names.size())))
        list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", name);
    if (names.size() > most) list += fmt::format(" and {} more", names.size() - most);
    return list;
}

}  // namespace haarfield
