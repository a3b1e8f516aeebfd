#pragma once
/// Vectors and colours: Imath's types under short names.
///
/// Frame   right-handed, +y up; metres. Directions are unit vectors that point away from the surface.
/// Colour  linear RGB, unbounded: radiance in W/(m^2 sr), or an albedo in [0, 1].

#include <Imath/ImathColor.h>
#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>

namespace haarfield {

using Vec3f = Imath::V3f;    ///< For storage.
using Vec3d = Imath::V3d;    ///< For references and long sums.
using Vec2f = Imath::V2f;    ///< A position in an image: (0, 0) lower left, (1, 1) upper right.
using Rgb = Imath::Color3f;  ///< Arithmetic is per channel, `*` included.

/// The ratio of a circle's circumference to its diameter.
inline constexpr double pi = 3.14159265358979323846;

/// True if all components are finite.
inline bool is_finite(const Vec3f& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Returns the relative luminance of linear Rec. 709 RGB, in the colour's unit.
inline float luminance(const Rgb& c) {
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

/// Returns the square in double precision.
inline double squared(float value) {
    return double(value) * value;
}
/// Returns the sum of the squared channels.
inline double squared(const Rgb& c) {
    return squared(c.x) + squared(c.y) + squared(c.z);
}

/// Clamps negative channels to zero.
inline Rgb without_negative(const Rgb& c) {
    return Rgb(std::max(c.x, 0.0f), std::max(c.y, 0.0f), std::max(c.z, 0.0f));
}

/// Two unit vectors that form an orthonormal frame with a given direction.
template <class V>
struct Axes {
    V across, up;  ///< across x up is the direction.
};

/// Returns two unit vectors that form an orthonormal frame with a unit direction.
template <class V>
Axes<V> axes_across(const V& direction) {
    using Number = decltype(direction.x);
    const V any = std::abs(direction.y) < Number(0.9) ? V(0, 1, 0) : V(1, 0, 0),
            across = any.cross(direction).normalized();
    return {across, direction.cross(across)};
}

}  // namespace haarfield
