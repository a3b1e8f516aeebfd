#pragma once
/// Pictures as arrays.

#include "scenes/image.h"

#include <pybind11/numpy.h>

namespace haarfield::python {

namespace py = pybind11;

/// (height, width, 3), the picture's own memory.
py::array pixels_of(const std::shared_ptr<const Image>& image);

/// (height, width), or None.
py::object coverage_of(const std::shared_ptr<const Image>& image);

/// A picture of an array of (height, width, 3) or, with coverage, (height, width, 4); or a file's.
Image image_of(const py::object& picture, const std::string& name);

}  // namespace haarfield::python
