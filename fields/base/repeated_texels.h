#pragma once
/// Texels of images that repeat in both directions.

#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace haarfield {

/// The row or column that a whole number means.
inline int repeated(std::int64_t at, int size) {
    const auto rest = static_cast<int>(at % size);
    return rest < 0 ? rest + size : rest;
}

/// The number of a texel, row by row.
inline std::size_t repeated_texel(std::int64_t column, std::int64_t row, int width, int height) {
    return std::size_t(repeated(row, height)) * std::size_t(width) + std::size_t(repeated(column, width));
}

/// Whether a test holds for the number of a texel that bilinear lookup takes somewhere in a box.
///
/// lower, upper  corners of the box: x right, y down, 1 the image's width and height.
template <class Test>
bool any_texel(const Imath::V2d& lower, const Imath::V2d& upper, int width, int height, const Test& test) {
    const auto first = [](double at) { return static_cast<std::int64_t>(std::floor(at - 0.5)); };
    const std::int64_t left = first(lower.x * width), top = first(lower.y * height),
                       right = std::min(first(upper.x * width) + 1, left + width - 1),
                       bottom = std::min(first(upper.y * height) + 1, top + height - 1);
    for (std::int64_t row = top; row <= bottom; ++row)
        for (std::int64_t column = left; column <= right; ++column)
            if (test(repeated_texel(column, row, width, height))) return true;
    return false;
}

}  // namespace haarfield
