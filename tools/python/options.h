#pragma once
/// Converts keyword arguments to render options.

#include "tools/render_options.h"

#include <pybind11/pybind11.h>

namespace haarfield::python {

namespace py = pybind11;

/// Reads options from keyword arguments. Options that are not given keep their defaults. None means no value
/// for optional values, and `auto` for bounces.
///
/// function  the name in the messages of exceptions.
/// raises    TypeError for unknown keywords; ValueError for invalid values.
RenderChoices render_choices(const py::kwargs& given, std::initializer_list<OptionSet> sets,
                             const char* function);

/// Returns the docstring of a method whose keywords are options: signature, `text` and a line per option.
///
/// before  further arguments, such as `points: int = 400`; may be empty. `progress` comes last.
std::string option_docstring(const std::string& name, const std::string& before,
                             std::initializer_list<OptionSet> sets, const std::string& returned,
                             const std::string& text);

}  // namespace haarfield::python
