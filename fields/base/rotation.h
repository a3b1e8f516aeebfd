#pragma once
/// Rotations, and their angles in scene files.

#include <array>

#include "fields/base/vector.h"

namespace haarfield {

/// A rotation about the origin, as an orthonormal matrix.
struct Rotation {
    std::array<Vec3d, 3> row{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};

    /// Rotates a vector.
    Vec3d operator()(const Vec3d& v) const { return {row[0].dot(v), row[1].dot(v), row[2].dot(v)}; }
    Vec3f operator()(const Vec3f& v) const { return Vec3f((*this)(Vec3d(v))); }  ///< Rotates a vector.

    /// Applies the inverse rotation.
    Vec3f back(const Vec3f& v) const {
        return Vec3f(row[0] * double(v.x) + row[1] * double(v.y) + row[2] * double(v.z));
    }
    Rotation inverse() const;  ///< The inverse rotation.

    bool operator==(const Rotation&) const = default;  ///< Exact, except that -0 equals 0.
};

/// True if the rotation is exactly the identity.
inline bool is_identity(const Rotation& rotation) {
    return rotation == Rotation();
}

/// Returns the composition of two rotations: `first`, then `second`.
Rotation operator*(const Rotation& second, const Rotation& first);

/// Returns a rotation that is counter-clockwise as viewed from the tip of the axis. The axis need not be a
/// unit vector, but must not be zero. [rad]
Rotation rotation_about(const Vec3d& axis, double angle);

/// Returns the rotation about x, then y, then z: the key `rotate` of scene files. [rad]
Rotation rotation_xyz(const Vec3f& angles);

/// The inverse of rotation_xyz. angles[1] is in [-pi/2, pi/2]; at either end, angles[2] is 0.
Vec3f angles_xyz(const Rotation& rotation);

float radians(float degrees);  ///< Converts degrees, as in files. [rad]

/// Returns degrees for which radians() is exactly the given angle, if they exist, and the nearest otherwise.
float degrees(float radians);

/// Returns the rotation about x, then y, then z: the key `rotate` of scene files. [degrees]
Rotation rotation_of_degrees(const Vec3f& angles);

/// Returns angles for rotation_of_degrees. They reproduce the rotation within 1e-6. They reproduce it exactly
/// if it is a result of as_degrees, or a rotation about x, y or z by at most half a turn.
Vec3f degrees_xyz(const Rotation& rotation);

/// Returns a rotation within 1e-6 of this one that degrees_xyz reproduces exactly.
Rotation as_degrees(const Rotation& rotation);

}  // namespace haarfield
