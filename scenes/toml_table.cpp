#include "scenes/toml_table.h"

#include <fmt/format.h>

#include <cmath>

#include "fields/file/input_file.h"

namespace haarfield {

namespace {

constexpr std::size_t largest_file = std::size_t{16} << 20;  // In bytes.
constexpr int longest_key = 100;                             // In parts.

// Formats a position. Tables that a program built have no lines.
std::string place(const std::string& file, const toml::source_position& position) {
    if (position.line == 0) return file;
    return fmt::format("{}:{}:{}", file, position.line, position.column);
}

// Describes a value in a message: numbers and short strings themselves, other values by their type.
std::string description(const toml::node& node) {
    if (const auto* integer = node.as_integer()) return fmt::format("{}", integer->get());
    if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
    if (const auto* boolean = node.as_boolean()) return boolean->get() ? "true" : "false";
    if (const auto* text = node.as_string())
        return text->get().size() <= 80 ? fmt::format("\"{}\"", text->get()) : "a long string";
    if (const auto* array = node.as_array()) return fmt::format("a list of {}", array->size());
    if (node.is_table()) return "a table";
    return "a date or time";
}

// Refuses text that toml++ 3.3 can not parse safely. Non-ASCII characters outside quotes and comments reach
// code that it marks as unreachable. Keys of very many parts overflow the stack, as tables are destroyed
// recursively. Multi-line strings are refused because scene files have no use for them.
std::optional<Error> unparsable(std::string_view text, const std::string& file) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    std::uint32_t line = 1, column = 0;
    int dots = 0;
    char quote = 0;  // The delimiter of the string or comment ('#') at `i`; 0 outside.
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) ++column;
        const auto refused = [&](std::string what) {
            return Error{place(file, {line, column}), std::move(what)};
        };
        if (c == '\n') {
            ++line;
            column = 0;
            dots = 0;
            quote = 0;
        } else if (quote != 0) {
            if (c == quote && quote != '#') quote = 0;
            if (c == '\\' && quote == '"' && i + 1 < text.size() && text[i + 1] != '\n') ++i, ++column;
        } else if (c == '"' || c == '\'') {
            if (text.substr(i).starts_with(c == '"' ? "\"\"\"" : "'''"))
                return refused("found a multi-line string; expected a string on one line");
            quote = c;
        } else if (c == '#') {
            quote = '#';
        } else if (static_cast<unsigned char>(c) >= 128) {
            return refused("found a non-ASCII character outside quotation marks; expected a quoted key");
        } else if (c == '.') {
            if (++dots >= longest_key)
                return refused(fmt::format("found a key of more than {} parts; expected fewer", longest_key));
        } else if (std::string_view(",={}[]").find(c) != std::string_view::npos) {
            dots = 0;
        }
    }
    return std::nullopt;
}

}  // namespace

void TomlFile::refuse(const toml::source_region& where, std::string what) {
    if (!error) error = Error{place(name, where.begin), std::move(what)};
}

Result<toml::table> read_toml(const std::filesystem::path& file) {
    HF_TRY(const std::string text, read_whole_file(file, largest_file));
    if (auto error = unparsable(text, file.string())) return *std::move(error);
    try {
        return toml::parse(text, file.string());
    } catch (const toml::parse_error& error) {
        return Error{place(file.string(), error.source().begin), std::string(error.description())};
    }
}

const toml::node* TomlTable::node(std::string_view key) {
    known_.emplace(key);
    return table_->get(key);
}

std::string TomlTable::key_name(std::string_view key) const {
    return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
}

void TomlTable::refuse(std::string_view key, std::string what) {
    const toml::node* value = table_->get(key);
    file_->refuse(value != nullptr ? value->source() : table_->source(), std::move(what));
}

std::optional<double> TomlTable::number(const toml::node& node, const std::string& key, const Range& range) {
    const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
    if (value && range.contains(*value)) return value;
    file_->refuse(node.source(), fmt::format("{} is {}; expected {}{}", key, description(node),
                                             value ? "" : "a number in ", range.text()));
    return std::nullopt;
}

template <std::size_t n>
std::optional<std::array<double, n>> TomlTable::numbers(const toml::node& node, const std::string& key,
                                                        const Range& range, bool whole) {
    const toml::array* list = node.as_array();
    if (list == nullptr || list->size() != n) {
        file_->refuse(node.source(), fmt::format("{} is {}; expected {} {}numbers in {}", key,
                                                 description(node), n, whole ? "whole " : "", range.text()));
        return std::nullopt;
    }
    std::array<double, n> values{};
    for (std::size_t i = 0; i < n; ++i) {
        const std::string name = fmt::format("{}[{}]", key, i);
        if (whole && !list->get(i)->is_integer()) {
            file_->refuse(list->get(i)->source(), fmt::format("{} is {}; expected a whole number in {}", name,
                                                              description(*list->get(i)), range.text()));
            return std::nullopt;
        }
        const std::optional<double> value = number(*list->get(i), name, range);
        if (!value) return std::nullopt;
        values[i] = *value;
    }
    return values;
}

void TomlTable::take(std::string_view key, float& value, const Range& range) {
    const toml::node* found = node(key);
    if (found == nullptr) return;
    if (const auto taken = number(*found, key_name(key), range)) value = static_cast<float>(*taken);
}

void TomlTable::take(std::string_view key, std::optional<float>& value, const Range& range,
                     std::string_view word) {
    const toml::node* found = node(key);
    if (found == nullptr) return;
    const auto* text = found->as_string();
    if (text != nullptr && text->get() == word) {
        value.reset();
    } else if (text != nullptr) {
        refuse(key, fmt::format("{} is {}; expected \"{}\" or a number in {}", key_name(key),
                                description(*found), word, range.text()));
    } else if (const auto taken = number(*found, key_name(key), range)) {
        value = static_cast<float>(*taken);
    }
}

void TomlTable::take(std::string_view key, Vec3f& value, const Range& range) {
    const toml::node* found = node(key);
    if (found == nullptr) return;
    if (const auto taken = numbers<3>(*found, key_name(key), range, false))
        value = Vec3f(static_cast<float>((*taken)[0]), static_cast<float>((*taken)[1]),
                      static_cast<float>((*taken)[2]));
}

void TomlTable::take(std::string_view key, Rgb& value, const Range& range) {
    Vec3f channels(value.x, value.y, value.z);
    take(key, channels, range);
    value = Rgb(channels.x, channels.y, channels.z);
}

void TomlTable::take(std::string_view key, std::uint32_t& value, const Range& range) {
    const toml::node* found = node(key);
    if (found == nullptr) return;
    if (!found->is_integer()) {
        refuse(key, fmt::format("{} is {}; expected a whole number in {}", key_name(key), description(*found),
                                range.text()));
        return;
    }
    if (const auto taken = number(*found, key_name(key), range)) value = static_cast<std::uint32_t>(*taken);
}

void TomlTable::take(std::string_view key, std::array<std::uint32_t, 2>& value, const Range& range) {
    const toml::node* found = node(key);
    if (found == nullptr) return;
    if (const auto taken = numbers<2>(*found, key_name(key), range, true))
        value = {static_cast<std::uint32_t>((*taken)[0]), static_cast<std::uint32_t>((*taken)[1])};
}

void TomlTable::take_factors(std::string_view key, Vec3d& value, const Range& magnitudes) {
    const toml::node* found = node(key);
    if (found == nullptr) return;
    const auto take_one = [&](const toml::node& from, const std::string& name, double& factor) {
        const std::optional<double> taken = from.is_number() ? from.value<double>() : std::nullopt;
        if (taken && magnitudes.contains(std::abs(*taken)))
            factor = *taken;
        else
            file_->refuse(from.source(), fmt::format("{} is {}; expected {} with either sign", name,
                                                     description(from), magnitudes.text()));
    };
    if (found->is_number()) {
        take_one(*found, key_name(key), value.x);
        value.y = value.z = value.x;
    } else if (const toml::array* list = found->as_array(); list != nullptr && list->size() == 3) {
        for (int axis = 0; axis < 3; ++axis)
            take_one(*list->get(std::size_t(axis)), fmt::format("{}[{}]", key_name(key), axis), value[axis]);
    } else {
        refuse(key, fmt::format("{} is {}; expected a number or 3 numbers in {} with either sign",
                                key_name(key), description(*found), magnitudes.text()));
    }
}

void TomlTable::take_matrix(std::string_view key, std::array<std::array<double, 4>, 3>& value,
                            const Range& range) {
    const toml::node* found = node(key);
    if (found == nullptr) return;
    const toml::array* list = found->as_array();
    if (list == nullptr || (list->size() != 3 && list->size() != 4))
        return refuse(key, fmt::format("{} is {}; expected 3 rows of 4 numbers in {}, optionally "
                                       "followed by 0 0 0 1",
                                       key_name(key), description(*found), range.text()));
    for (std::size_t row = 0; row < list->size(); ++row) {
        const std::string name = fmt::format("{}[{}]", key_name(key), row);
        const auto taken = numbers<4>(*list->get(row), name, range, false);
        if (!taken) return;
        if (row < 3)
            value[row] = *taken;
        else if (*taken != std::array<double, 4>{0, 0, 0, 1})
            file_->refuse(
                list->get(row)->source(),
                fmt::format("{} is {} {} {} {}; expected 0 0 0 1 (matrices multiply column vectors)", name,
                            (*taken)[0], (*taken)[1], (*taken)[2], (*taken)[3]));
    }
}

void TomlTable::take(std::string_view key, std::string& value) {
    const toml::node* found = node(key);
    if (found == nullptr) return;
    if (const auto* text = found->as_string())
        value = text->get();
    else
        refuse(key, fmt::format("{} is {}; expected a string", key_name(key), description(*found)));
}

void TomlTable::take(std::string_view key, bool& value) {
    const toml::node* found = node(key);
    if (found == nullptr) return;
    if (const auto* said = found->as_boolean())
        value = said->get();
    else
        refuse(key, fmt::format("{} is {}; expected true or false", key_name(key), description(*found)));
}

void TomlTable::take(std::string_view key, std::filesystem::path& value,
                     const std::filesystem::path& folder) {
    if (node(key) == nullptr) return;
    std::string text;
    take(key, text);
    if (file_->error) return;
    if (text.empty() || text.find('\0') != std::string::npos)
        return refuse(key, fmt::format("{} is not a valid file name", key_name(key)));
    if (file_->given != nullptr && file_->given->contains(text)) {
        value = text;
        return;
    }
    value = folder / text;
    std::error_code failure;
    // `a/../b` is simplified to `b` unless a symbolic link makes them different.
    if (const std::filesystem::path plain = value.lexically_normal();
        std::filesystem::equivalent(value, plain, failure) && !failure)
        value = plain;
    if (const Result<Done> good = check_input_file(value); !good)
        refuse(key, fmt::format("{} is {}: {}", key_name(key), value.string(), good.error().what));
}

const toml::table* TomlTable::take_table(std::string_view key) {
    const toml::node* found = node(key);
    if (found == nullptr) return nullptr;
    if (!found->is_table())
        refuse(key, fmt::format("{} is {}; expected a table", key_name(key), description(*found)));
    return found->as_table();
}

const toml::array* TomlTable::take_array(std::string_view key) {
    const toml::node* found = node(key);
    if (found == nullptr) return nullptr;
    if (!found->is_array())
        refuse(key, fmt::format("{} is {}; expected a list", key_name(key), description(*found)));
    return found->as_array();
}

void TomlTable::finish() {
    for (const auto& [key, value] : *table_) {
        if (known_.contains(key.str())) continue;
        std::string wanted;
        for (const std::string& name : known_) wanted += (wanted.empty() ? "" : ", ") + name;
        file_->refuse(key.source(),
                      fmt::format("{} is not known; expected one of: {}", key_name(key.str()), wanted));
    }
    for (const std::string& key : required_)
        if (!has(key)) file_->refuse(table_->source(), fmt::format("{} is missing", key_name(key)));
}

}  // namespace haarfield
