#pragma once
/// Options that take numbers: a command takes them in no other way.

#include "tools/number_text.h"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace haarfield {

/// Refuses texts without a number_in. The message says what was found and which range was wanted; --help
/// shows the range.
CLI::Validator number_check(const Range& range, bool whole);

/// What the numbers of an option are: those of a list, if it has one, or the one that may be there.
template <class T>
struct OptionNumber {
    using Type = T;
};
template <class T>
struct OptionNumber<std::optional<T>> {
    using Type = T;
};
template <class T>
struct OptionNumber<std::vector<T>> {
    using Type = T;
};

/// Adds an option whose value is a number, may be one, or is a list of them, all in the range.
template <class T>
CLI::Option* add_number(CLI::App& command, const std::string& name, T& value, const std::string& description,
                        const Range& range) {
    return command.add_option(name, value, description)
        ->check(number_check(range, std::is_integral_v<typename OptionNumber<T>::Type>));
}

/// Adds an option whose value is a number of the range, or a word instead of one; kept as text.
CLI::Option* add_number_or_word(CLI::App& command, const std::string& name, std::string& text,
                                const std::string& description, const Range& range, const std::string& word);

}  // namespace haarfield
