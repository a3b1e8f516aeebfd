#pragma once
/// Vectors and colours: Imath's, under the names that haarfield uses.
///
/// Frame   right-handed, +y up; metres. Directions are unit vectors that point away from the surface.
/// Colour  linear RGB, unbounded: radiance in W/(m^2 sr), or an albedo in [0, 1].

#include <Imath/ImathColor.h>
#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>

namespace haarfield {

using Vec3f = Imath::V3f;    ///< In storage.
using Vec3d = Imath::V3d;    ///< In references and long sums.
using Vec2f = Imath::V2f;    ///< A place in an image: (0, 0) lower left, (1, 1) upper right.
using Rgb = Imath::Color3f;  ///< Arithmetic is per channel, `*` included.

inline constexpr double pi = 3.14159265358979323846;  ///< A circle's circumference to its diameter.

/// No component is infinite or NaN.
inline bool is_finite(const Vec3f& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Relative luminance of linear Rec. 709 RGB, in the colour's unit.
inline float luminance(const Rgb& c) {
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

/// In double.
inline double squared(float value) {
    return double(value) * value;
}
/// Summed over the channels.
inline double squared(const Rgb& c) {
    return squared(c.x) + squared(c.y) + squared(c.z);
}

/// Negative channels become zero.
inline Rgb without_negative(const Rgb& c) {
    return Rgb(std::max(c.x, 0.0f), std::max(c.y, 0.0f), std::max(c.z, 0.0f));
}

/// Two unit vectors at right angles to a third and to each other.
template <class V>
struct Axes {
    V across, up;  ///< across x up is the third.
};
template <class V>
Axes<V> axes_across(const V& direction) {
    using Number = decltype(direction.x);
    const V any = std::abs(direction.y) < Number(0.9) ? V(0, 1, 0) : V(1, 0, 0),
            across = any.cross(direction).normalized();
    return {across, direction.cross(across)};
}

}  // namespace haarfield
