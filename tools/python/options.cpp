#include "tools/python/options.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield::python {

namespace {

std::string keyword_of(const RenderOption& row) {
    std::string keyword = row.is_list ? row.name + "es" : row.name;
    std::ranges::replace(keyword, '-', '_');
    return keyword;
}

/// True if None is valid and represents no value, or `auto`.
bool accepts_none(const RenderOption& row) {
    return row.is_optional ||
           (row.range && std::ranges::find(row.words, row.text(RenderChoices())) != row.words.end());
}

std::string text_of(const py::handle& value) {
    if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "true" : "false";
    if (py::isinstance<py::str>(value) || !py::isinstance<py::sequence>(value)) return py::str(value);
    std::string list;
    for (const py::handle word : value) list += (list.empty() ? "" : ",") + py::str(word).cast<std::string>();
    return list;
}

/// Returns an argument of a signature: `occlusion: str = 'auto'`.
std::string argument_text(const RenderOption& row) {
    const std::string text = row.text(RenderChoices());
    const bool is_number = row.range || row.is_whole;
    const std::string type = row.is_flag    ? "bool"
                             : row.is_list  ? "Sequence[str]"
                             : !is_number   ? "str"
                             : row.is_whole ? "int"
                             : row.is_share ? "float | str"
                                            : "float";
    const std::string value = row.is_flag         ? (text == "true" ? "True" : "False")
                              : row.is_list       ? "[]"
                              : accepts_none(row) ? "None"
                              : is_number         ? text
                                                  : "'" + text + "'";
    return fmt::format("{}: {}{} = {}", keyword_of(row), type, accepts_none(row) ? " | None" : "", value);
}

}  // namespace

RenderChoices render_choices(const py::kwargs& given, std::initializer_list<OptionSet> sets,
                             const char* function) {
    const std::vector<const RenderOption*> rows = render_options(sets);
    RenderChoices choices;
    for (const auto& [key, value] : given) {
        const auto name = key.cast<std::string>();
        const auto row =
            std::ranges::find(rows, name, [](const RenderOption* of) { return keyword_of(*of); });
        if (row == rows.end())
            throw py::type_error(fmt::format("{}: got an unexpected keyword argument '{}'", function, name));
        if (value.is_none() && accepts_none(**row)) continue;
        const std::string text = text_of(value);
        if ((*row)->is_list && text.empty()) continue;
        if (const std::string trouble = (*row)->trouble(text); !trouble.empty())
            throw py::value_error(name + " " + trouble);
        (*row)->set_text(choices, text);
    }
    return choices;
}

std::string option_docstring(const std::string& name, const std::string& before,
                             std::initializer_list<OptionSet> sets, const std::string& returned,
                             const std::string& text) {
    std::string arguments = "self: haarfield._haarfield.Scene", lines;
    if (!before.empty()) arguments += ", " + before;
    arguments += ", *";
    for (const RenderOption* row : render_options(sets)) {
        arguments += ", " + argument_text(*row);
        const std::string words = row->range || row->is_flag ? "" : " " + row->values();
        lines += fmt::format("\n{:<18} {}{}.", keyword_of(*row), row->summary, words);
        if (!row->details.empty()) lines += "\n    " + row->details;
    }
    return fmt::format(
        "{}({}, progress: object = None) -> {}\n\n{}\n{}\n{:<18} Called with (stage, done, total) about "
        "twenty times per second.",
        name, arguments, returned, text, lines, "progress");
}

}  // namespace haarfield::python
