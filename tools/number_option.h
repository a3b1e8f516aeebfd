#pragma once
/// Options with numbers. Commands parse numbers in no other way.

#include "tools/number_text.h"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace haarfield {

/// Returns a validator that rejects texts without a number_in. Its message has the text and the expected
/// range;
/// --help shows the range.
CLI::Validator number_check(const Range& range, bool whole);

/// The type of an option's number: that of a list's elements, or of an optional value.
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

/// Adds an option whose value is a number in the range, an optional number, or a list of numbers.
template <class T>
CLI::Option* add_number(CLI::App& command, const std::string& name, T& value, const std::string& description,
                        const Range& range) {
    return command.add_option(name, value, description)
        ->check(number_check(range, std::is_integral_v<typename OptionNumber<T>::Type>));
}

/// Adds an option whose value is a number in the range or a word, stored as text.
CLI::Option* add_number_or_word(CLI::App& command, const std::string& name, std::string& text,
                                const std::string& description, const Range& range, const std::string& word);

}  // namespace haarfield
