#pragma once
/// Converts between pictures and arrays.

#include "scenes/image.h"

#include <pybind11/numpy.h>

namespace haarfield::python {

namespace py = pybind11;

/// Returns (height, width, 3), a view of the picture's memory.
py::array pixels_of(const std::shared_ptr<const Image>& image);

/// Returns (height, width), or None without coverage.
py::object coverage_of(const std::shared_ptr<const Image>& image);

/// Returns the picture of an array of (height, width, 3), or (height, width, 4) with coverage; or of a file.
Image image_of(const py::object& picture, const std::string& name);

}  // namespace haarfield::python
