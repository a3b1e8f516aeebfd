#pragma once
/// Evenly distributed directions, in any number.

#include "fields/base/vector.h"

namespace haarfield {

/// The angle between consecutive directions of a spiral, which avoids rows of aligned directions: pi (3 -
/// sqrt(5)). [rad]
inline constexpr double golden_angle = 2.399963229728653;

/// Returns direction i of a spiral about z with steps of the golden angle. The distribution of heights
/// determines the density:
///
///     heights uniform in [-1, 1]          uniform over the sphere
///     heights uniform in [0, 1]           uniform over the upper hemisphere
///     squared heights uniform in [0, 1]   proportional to the cosine with z
///
/// height  z of the direction, in [-1, 1].
inline Vec3d spiral_direction(std::size_t i, double height) {
    const double angle = golden_angle * double(i), around = std::sqrt(1 - height * height);
    return {around * std::cos(angle), around * std::sin(angle), height};
}

}  // namespace haarfield
