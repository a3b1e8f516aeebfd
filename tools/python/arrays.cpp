#include "tools/python/arrays.h"

#include <fmt/format.h>

#include <cmath>

namespace haarfield::python {

namespace {

std::string wanted_text(const std::vector<py::ssize_t>& shape) {
    std::string text;
    for (const py::ssize_t length : shape)
        text += (text.empty() ? "" : ", ") + (length == any_length ? "N" : std::to_string(length));
    return fmt::format("({}{})", text, shape.size() == 1 ? "," : "");
}

/// Returns an array of the given shape, of any element type.
///
/// kinds  accepted kinds of numpy's types.
py::array shaped(const py::handle& numbers, const std::string& name, const std::vector<py::ssize_t>& shape,
                 const char* kinds, const char* wanted) {
    const auto array = py::array::ensure(numbers);
    if (!array) {
        PyErr_Clear();
        throw py::type_error(fmt::format("{} is not an array; expected {}", name, wanted));
    }
    if (array.size() > 0 && std::string_view(kinds).find(array.dtype().kind()) == std::string_view::npos)
        throw py::type_error(fmt::format("{} has elements of type {}; expected {}", name,
                                         py::str(array.dtype()).cast<std::string>(), wanted));
    bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
    for (std::size_t i = 0; fits && i < shape.size(); ++i)
        fits = shape[i] == any_length || array.shape(py::ssize_t(i)) == shape[i];
    if (!fits)
        throw py::value_error(
            fmt::format("{} has the shape {}; expected {}", name, shape_text(array), wanted_text(shape)));
    return array;
}

}  // namespace

std::string shape_text(const py::array& array) {
    return py::str(array.attr("shape")).cast<std::string>();
}

FloatArray floats(const py::handle& numbers, const std::string& name, const std::vector<py::ssize_t>& shape) {
    const auto array = FloatArray::ensure(shaped(numbers, name, shape, "fiu", "real numbers"));
    if (!array) throw py::error_already_set();
    for (py::ssize_t i = 0; i < array.size(); ++i)
        if (!std::isfinite(array.data()[i])) {
            const py::tuple place =
                py::module_::import("numpy").attr("unravel_index")(i, array.attr("shape"));
            std::string text;
            for (const py::handle& index : place)
                text += (text.empty() ? "" : ", ") + py::str(index).cast<std::string>();
            throw py::value_error(
                fmt::format("{}[{}] is {}; expected a finite number", name, text, array.data()[i]));
        }
    return array;
}

py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast> indices(
    const py::handle& numbers, const std::string& name, const std::vector<py::ssize_t>& shape,
    std::uint64_t end) {
    using Wide = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;
    const auto wide = Wide::ensure(shaped(numbers, name, shape, "iu", "whole numbers"));
    if (!wide) throw py::error_already_set();
    py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast> result(
        std::vector<py::ssize_t>(wide.shape(), wide.shape() + wide.ndim()));
    for (py::ssize_t i = 0; i < wide.size(); ++i) {
        const std::int64_t index = wide.data()[i];
        if (index < 0 || static_cast<std::uint64_t>(index) >= end)
            throw py::value_error(fmt::format("{} contains {}; expected whole numbers from 0 to {}", name,
                                              index, static_cast<std::int64_t>(end) - 1));
        result.mutable_data()[i] = static_cast<std::uint32_t>(index);
    }
    return result;
}

Vec3f vector(const py::handle& numbers, const std::string& name) {
    const FloatArray array = floats(numbers, name, {3});
    return {array.data()[0], array.data()[1], array.data()[2]};
}

}  // namespace haarfield::python
