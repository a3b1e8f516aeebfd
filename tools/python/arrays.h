#pragma once
/// numpy arrays: views of haarfield's memory, and conversion of arguments.

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

/// An array of floats in row-major order.
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

inline constexpr py::ssize_t any_length = -1;

/// Returns real numbers of a given shape as floats. Copies only if the elements are not such floats.
///
/// name    the argument's name in messages.
/// shape   any_length accepts any length; messages call it N.
/// raises  TypeError if the argument is not an array of numbers; ValueError for another shape, NaN or
///         infinity.
FloatArray floats(const py::handle& numbers, const std::string& name, const std::vector<py::ssize_t>& shape);

/// Returns whole numbers from 0 up to but excluding `end`; otherwise like floats().
py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast> indices(
    const py::handle& numbers, const std::string& name, const std::vector<py::ssize_t>& shape,
    std::uint64_t end);

/// Returns float vectors from an array of shape (N, dimensions of Vector).
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

/// Returns a single vector.
Vec3f vector(const py::handle& numbers, const std::string& name);

/// The shape of an element in arrays.
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

/// Returns an array that refers to existing elements.
///
/// owner  keeps the elements alive; the array holds a reference to it.
/// shape  replaces the number of elements, if not empty.
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

/// Returns a read-only array that refers to existing elements.
template <class Element>
py::array view_of(std::span<const Element> elements, std::shared_ptr<const void> owner,
                  std::vector<py::ssize_t> shape = {}) {
    py::array array = array_at(elements, std::move(owner), std::move(shape));
    array.attr("flags").attr("writeable") = false;
    return array;
}

/// Returns an array that owns the elements.
template <class Element>
py::array array_of(std::vector<Element> elements, std::vector<py::ssize_t> shape = {}) {
    const auto owner = std::make_shared<const std::vector<Element>>(std::move(elements));
    return array_at<Element>(*owner, owner, std::move(shape));
}

/// Returns a shape as text: `(2, 3)`
std::string shape_text(const py::array& array);

}  // namespace haarfield::python
