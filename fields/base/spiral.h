#pragma once
/// Directions spread evenly, as many as one likes.

#include "fields/base/vector.h"

namespace haarfield {

/// How far each direction of a spiral turns on, so that none come to lie side by side: pi (3 - sqrt(5)).
/// [rad]
inline constexpr double golden_angle = 2.399963229728653;

/// The i-th of directions that wind about z by the golden angle. If their heights are spread evenly over
/// [-1, 1], they are over the sphere; over [0, 1], over the upper half of it; if the squares of their heights
/// are, they have the density of the cosine with z.
///
/// height  in [-1, 1]: the direction's z.
inline Vec3d spiral_direction(std::size_t i, double height) {
    const double angle = golden_angle * double(i), around = std::sqrt(1 - height * height);
    return {around * std::cos(angle), around * std::sin(angle), height};
}

}  // namespace haarfield
