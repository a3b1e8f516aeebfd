#pragma once
/// Directions for rays, spread as evenly as can be.

#include <array>
#include <cstdint>

#include "fields/base/vector.h"

namespace haarfield {

/// A point of Sobol's sequence in the unit square, [0, 1) x [0, 1). Of 2^m points from a multiple of 2^m on,
/// one lies in each rectangle of area 2^-m whose sides are powers of 1/2 and whose corners multiples of them:
/// runs of points that follow each other fill each other's gaps.
///
/// source  Sobol 1967, the first two dimensions.
Vec2f sobol_point(std::uint32_t index);

/// The same point's coordinates as binary fractions of 32 digits.
std::array<std::uint32_t, 2> sobol_digits(std::uint32_t index);

/// A direction with the density of the cosine above a surface, from a point of the unit square.
///
/// axes    across the normal.
/// source  the concentric map of square to disc: Shirley and Chiu 1997; what is even on the disc below a
///         hemisphere has the cosine's density on it.
Vec3f cosine_direction(const Vec2f& point, const Vec3f& normal, const Axes<Vec3f>& axes);

/// A direction with a density proportional to the given power of its cosine with an axis: (n + 1) / (2 pi)
/// cos^n.
///
/// axes  across the axis.
Vec3f power_direction(const Vec2f& point, float exponent, const Vec3f& axis, const Axes<Vec3f>& axes);

}  // namespace haarfield
