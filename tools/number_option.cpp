#include "tools/number_option.h"

#include <fmt/format.h>

namespace haarfield {

CLI::Validator number_check(const Range& range, bool whole) {
    return {[range, whole](const std::string& text) -> std::string {
                if (number_in(range, text, whole)) return {};
                return fmt::format("is {}; expected a {}number in {}", text, whole ? "whole " : "",
                                   range.text());
            },
            "in " + range.text()};
}

CLI::Option* add_number_or_word(CLI::App& command, const std::string& name, std::string& text,
                                const std::string& description, const Range& range, const std::string& word) {
    const auto check = [range, word](const std::string& given) -> std::string {
        if (given == word || number_in(range, given)) return {};
        return fmt::format("is {}; expected {} or a number in {}", given, word, range.text());
    };
    return command.add_option(name, text, description)->check(CLI::Validator(check, "in " + range.text()));
}

}  // namespace haarfield
