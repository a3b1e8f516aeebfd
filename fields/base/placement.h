#pragma once
/// The placement of an object in the world.

#include "fields/base/rotation.h"

namespace haarfield {

/// A similarity transform: world = translate + scale * rotate(object).
///
/// Directions and normals are only rotated. Distances in the world are `scale` times as long. Without a
/// rotation, directions are unchanged to the last bit.
struct Placement {
    Vec3f translate{0, 0, 0};  ///< [m]
    float scale = 1;           ///< > 0, finite.
    Rotation rotate{};         ///< About the object's origin.

    /// Maps a point from the object's frame to the world. [m]
    Vec3f point_to_world(const Vec3f& point) const { return rotate(point) * scale + translate; }
    /// Maps a point from the object's frame to the world. [m]
    Vec3d point_to_world(const Vec3d& point) const {
        return rotate(point) * double(scale) + Vec3d(translate);
    }
    /// Rotates a direction or normal from the object's frame to the world.
    Vec3f direction_to_world(const Vec3f& direction) const { return rotate(direction); }

    /// The inverse of point_to_world, up to rounding. [m]
    Vec3f point_to_object(const Vec3f& point) const { return rotate.back(point_to_turned(point)); }
    /// The inverse of direction_to_world, up to rounding.
    Vec3f direction_to_object(const Vec3f& direction) const { return rotate.back(direction); }

    /// Maps a world point to the object's rotated frame, which is neither scaled nor translated. [m]
    Vec3f point_to_turned(const Vec3f& point) const { return (point - translate) / scale; }

    /// Returns the map to the world as a 3 x 4 matrix in column-major order, as Embree expects it: the images
    /// of the axes, then the origin.
    std::array<float, 12> columns() const {
        std::array<float, 12> result;
        for (std::size_t row = 0; row < 3; ++row) {
            for (int axis = 0; axis < 3; ++axis)
                result[3 * std::size_t(axis) + row] =
                    static_cast<float>(rotate.row[row][axis] * double(scale));
            result[9 + row] = translate[int(row)];
        }
        return result;
    }

    bool operator==(const Placement&) const = default;  ///< Exact, except that -0 equals 0.
};

}  // namespace haarfield
