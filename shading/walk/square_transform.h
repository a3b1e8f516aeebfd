#pragma once
/// The Haar transform of the sixteen cells of a wide node.

#include "shading/walk/wide_tree.h"

namespace haarfield {

/// Transforms four means at distance `step` to their mean and their wavelets.
inline void transform_square(float* cell, std::size_t step) {
    float &a = cell[0], &b = cell[step], &c = cell[2 * step], &d = cell[3 * step];
    const float upper = a + b, lower = c + d, upper_slope = a - b, lower_slope = c - d;
    a = (upper + lower) * 0.25f;
    b = (upper_slope + lower_slope) * 0.25f;
    c = (upper - lower) * 0.25f;
    d = (upper_slope - lower_slope) * 0.25f;
}

}  // namespace haarfield
