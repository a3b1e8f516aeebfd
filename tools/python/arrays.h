#pragma once
/// numpy's arrays: views of haarfield's memory, and what is taken from them.

#include "fields/base/vector.h"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace haarfield::python {

namespace py = pybind11;

/// Floats, row by row.
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

inline constexpr py::ssize_t any_length = -1;

/// Real numbers of a shape, as floats; a copy only if they are no such floats yet.
///
/// name    what messages call it.
/// shape   any_length where any length will do, which the array's own text names N.
/// raises  TypeError for what is no array of numbers; ValueError for another shape, NaN or infinity.
FloatArray floats(const py::handle& numbers, const std::string& name, const std::vector<py::ssize_t>& shape);

/// The same of whole numbers from 0 up to, not including, `end`.
py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast> indices(
    const py::handle& numbers, const std::string& name, const std::vector<py::ssize_t>& shape,
    std::uint64_t end);

/// Vectors of floats, from an array of (N, dimensions of Vector).
template <class Vector>
std::vector<Vector> vectors(const py::handle& numbers, const std::string& name,
                            py::ssize_t length = any_length) {
    constexpr auto size = static_cast<py::ssize_t>(sizeof(Vector) / sizeof(float));
    const FloatArray array = floats(numbers, name, {length, size});
    std::vector<Vector> result(static_cast<std::size_t>(array.shape(0)));
    for (std::size_t i = 0; i < result.size(); ++i)
        for (py::ssize_t k = 0; k < size; ++k)
            result[i][static_cast<int>(k)] = array.data()[static_cast<py::ssize_t>(i) * size + k];
    return result;
}

/// One of them.
Vec3f vector(const py::handle& numbers, const std::string& name);

/// The shape that arrays of a kind of element have beside their length.
template <class Element>
struct ElementShape {
    using Number = Element;
    static constexpr std::array<py::ssize_t, 0> shape{};
};
template <>
struct ElementShape<Vec3f> {
    using Number = float;
    static constexpr std::array<py::ssize_t, 1> shape{3};
};
template <>
struct ElementShape<Rgb> {
    using Number = float;
    static constexpr std::array<py::ssize_t, 1> shape{3};
};
template <>
struct ElementShape<Vec2f> {
    using Number = float;
    static constexpr std::array<py::ssize_t, 1> shape{2};
};
template <class Number_, std::size_t n>
struct ElementShape<std::array<Number_, n>> {
    using Number = Number_;
    static constexpr std::array<py::ssize_t, 1> shape{py::ssize_t(n)};
};

/// An array of elements where they lie.
///
/// owner  keeps the elements in their place; the array keeps it.
/// shape  in place of the number of elements, if not empty.
template <class Element>
py::array array_at(std::span<const Element> elements, std::shared_ptr<const void> owner,
                   std::vector<py::ssize_t> shape) {
    using Shape = ElementShape<Element>;
    if (shape.empty()) shape = {static_cast<py::ssize_t>(elements.size())};
    shape.insert(shape.end(), Shape::shape.begin(), Shape::shape.end());
    const py::capsule base(new std::shared_ptr<const void>(std::move(owner)),
                           [](void* held) { delete static_cast<std::shared_ptr<const void>*>(held); });
    return {py::dtype::of<typename Shape::Number>(), std::move(shape), std::vector<py::ssize_t>(),
            reinterpret_cast<const typename Shape::Number*>(elements.data()), base};
}

/// The same, not to be written to.
template <class Element>
py::array view_of(std::span<const Element> elements, std::shared_ptr<const void> owner,
                  std::vector<py::ssize_t> shape = {}) {
    py::array array = array_at(elements, std::move(owner), std::move(shape));
    array.attr("flags").attr("writeable") = false;
    return array;
}

/// An array that takes the elements over.
template <class Element>
py::array array_of(std::vector<Element> elements, std::vector<py::ssize_t> shape = {}) {
    const auto owner = std::make_shared<const std::vector<Element>>(std::move(elements));
    return array_at<Element>(*owner, owner, std::move(shape));
}

/// `(2, 3)`
std::string shape_text(const py::array& array);

}  // namespace haarfield::python
