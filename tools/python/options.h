#pragma once
/// The table of render options as keyword arguments.

#include "tools/render_options.h"

#include <pybind11/pybind11.h>

namespace haarfield::python {

namespace py = pybind11;

/// Reads options from keyword arguments; one that is not given keeps its default. None leaves out an optional
/// value, and is `auto` for bounces.
///
/// raises  TypeError for other keywords, in the name of the function; ValueError for values out of range.
RenderChoices render_choices(const py::kwargs& given, std::initializer_list<OptionSet> sets,
                             const char* function);

/// The docstring of a method whose keywords are options: its signature, `text` and a line for each option.
///
/// before  further arguments, such as `points: int = 400`; may be empty. `progress` comes last.
std::string option_docstring(const std::string& name, const std::string& before,
                             std::initializer_list<OptionSet> sets, const std::string& returned,
                             const std::string& text);

}  // namespace haarfield::python
