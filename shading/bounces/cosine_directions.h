#pragma once
/// Low-discrepancy directions of rays, distributed by the cosine or by a power of a cosine.

#include <array>
#include <cstdint>

#include "fields/base/vector.h"

namespace haarfield {

/// Returns a point of Sobol's sequence in the unit square, [0, 1) x [0, 1).
///
/// Each run of 2^m points that starts at a multiple of 2^m is a (0, m, 2)-net in base 2: every elementary
/// rectangle of area 2^-m contains exactly one of the points. Consecutive runs fill each other's gaps.
///
/// source  Sobol 1967, the first two dimensions.
Vec2f sobol_point(std::uint32_t index);

/// Returns the coordinates of sobol_point as binary fractions of 32 digits.
std::array<std::uint32_t, 2> sobol_digits(std::uint32_t index);

/// Maps a point of the unit square to a direction above a surface, with a density proportional to the cosine.
///
/// axes    perpendicular to the normal.
/// source  the concentric map from square to disc of Shirley and Chiu 1997. Points that are uniform on the
///         unit disc, projected up to the hemisphere, have the density of the cosine.
Vec3f cosine_direction(const Vec2f& point, const Vec3f& normal, const Axes<Vec3f>& axes);

/// Maps a point of the unit square to a direction with density (n + 1) / (2 pi) cos^n, where n is the
/// exponent and cos the cosine of the angle to the axis.
///
/// axes  perpendicular to the axis.
Vec3f power_direction(const Vec2f& point, float exponent, const Vec3f& axis, const Axes<Vec3f>& axes);

}  // namespace haarfield
