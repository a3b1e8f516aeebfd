#pragma once
/// Rotations, and the angles that scene files have for them.

#include <array>

#include "fields/base/vector.h"

namespace haarfield {

/// A rotation about the origin, as an orthonormal matrix.
struct Rotation {
    std::array<Vec3d, 3> row{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};

    /// A vector, turned.
    Vec3d operator()(const Vec3d& v) const { return {row[0].dot(v), row[1].dot(v), row[2].dot(v)}; }
    Vec3f operator()(const Vec3f& v) const { return Vec3f((*this)(Vec3d(v))); }  ///< A vector, turned.

    /// What is turned to `v`.
    Vec3f back(const Vec3f& v) const {
        return Vec3f(row[0] * double(v.x) + row[1] * double(v.y) + row[2] * double(v.z));
    }
    Rotation inverse() const;  ///< Turns back.

    bool operator==(const Rotation&) const = default;  ///< Equal in all bits, but for signs of zeros.
};

/// Whether it turns nothing: to the last bit.
inline bool is_identity(const Rotation& rotation) {
    return rotation == Rotation();
}

/// `second` after `first`.
Rotation operator*(const Rotation& second, const Rotation& first);

/// Counter-clockwise seen from the tip of the axis. The axis has any length but zero. [rad]
Rotation rotation_about(const Vec3d& axis, double angle);

/// About x, then y, then z: what scene files call `rotate`. [rad]
Rotation rotation_xyz(const Vec3f& angles);

/// The inverse: angles[1] in [-pi/2, pi/2]; where it is at an end, angles[2] = 0.
Vec3f angles_xyz(const Rotation& rotation);

float radians(float degrees);  ///< Of an angle in degrees, as files have them. [rad]

/// Degrees whose radians() is the angle, to the last bit where there are such; the nearest otherwise.
float degrees(float radians);

/// What files call `rotate`: about x, then y, then z. [degrees]
Rotation rotation_of_degrees(const Vec3f& angles);

/// Degrees whose rotation_of_degrees is the rotation: to the last bit where that was made of angles about one
/// axis, of at most half a turn, or of what as_degrees has made; to 1e-6 otherwise.
Vec3f degrees_xyz(const Rotation& rotation);

/// A rotation that degrees can say to the last bit, within 1e-6 of this.
Rotation as_degrees(const Rotation& rotation);

}  // namespace haarfield
