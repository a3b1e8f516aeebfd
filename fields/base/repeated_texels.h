#pragma once
/// Texels of images that repeat in both directions.

#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace haarfield {

/// Wraps a row or column index into [0, size).
inline int repeated(std::int64_t at, int size) {
    const auto rest = static_cast<int>(at % size);
    return rest < 0 ? rest + size : rest;
}

/// Returns the index of a texel in row-major order; column and row wrap around.
inline std::size_t repeated_texel(std::int64_t column, std::int64_t row, int width, int height) {
    return std::size_t(repeated(row, height)) * std::size_t(width) + std::size_t(repeated(column, width));
}

/// Tests whether `test` is true for the index of any texel that bilinear lookups inside a box read.
///
/// lower, upper  corners of the box: x right, y down; 1 is the image's width and height.
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
