#pragma once
/// Stores values for many triangles in one image, linear over each triangle.

#include "scenes/image.h"

#include <array>
#include <string>
#include <type_traits>
#include <vector>

namespace haarfield {

/// An image with a square of 2 x 2 texels for each triangle, row by row. Three texels are the triangle's
/// corners. The fourth is the sum of the two adjacent corners minus the opposite one, so that bilinear
/// interpolation is linear.
class TriangleAtlas {
public:
    explicit TriangleAtlas(std::size_t triangles);  ///< The number of triangles, at least one (asserted).

    int width() const { return static_cast<int>(2 * columns_); }  ///< [texels]
    int height() const { return static_cast<int>(2 * rows_); }    ///< [texels]

    /// Returns the texels of values at triangles' corners.
    ///
    /// corners  returns the three values of a triangle by its index.
    template <class Corners>
    auto texels(const Corners& corners) const {
        using Value = typename std::invoke_result_t<Corners, std::size_t>::value_type;
        const std::size_t across = 2 * columns_;
        std::vector<Value> result(across * 2 * rows_, Value(0.0f));
        for (std::size_t t = 0; t < triangles_; ++t) {
            const auto [a, b, c] = corners(t);
            Value* const square = &result[y(t) * across + x(t)];
            square[0] = a;
            square[1] = b;
            square[across] = c;
            square[across + 1] = b + c - a;
        }
        return result;
    }

    /// Returns the texels as an image; texels may be negative. Light above 32,500 is not linear in a written
    /// image, because the fourth texel may be clipped.
    template <class Corners>
    Image image(const Corners& corners) const {
        Image image;
        image.width = width();
        image.height = height();
        image.pixels = texels(corners);
        return image;
    }

    /// Returns the positions of a triangle's corners in texels from the top left, for use with pigment().
    std::array<Vec2f, 3> uvs(std::size_t triangle) const;

    /// Returns a pigment of an image of these texels, for such uvs.
    ///
    /// image  `exr "name"` and further options of POV-Ray's image.
    std::string pigment(const std::string& image) const;

private:
    std::size_t x(std::size_t triangle) const { return 2 * (triangle % columns_); }
    std::size_t y(std::size_t triangle) const { return 2 * (triangle / columns_); }

    std::size_t triangles_, columns_, rows_;  ///< Of squares.
};

}  // namespace haarfield
