#pragma once
/// Where an object stands in the world.

#include "fields/base/rotation.h"

namespace haarfield {

/// world = translate + scale * rotate(object).
///
/// Directions and normals are turned alone; distances in the world are `scale` times as long. What is not
/// turned at all keeps every bit of its directions.
struct Placement {
    Vec3f translate{0, 0, 0};  ///< [m]
    float scale = 1;           ///< > 0, finite.
    Rotation rotate{};         ///< About the object's origin.

    /// A point of the object in the world. [m]
    Vec3f point_to_world(const Vec3f& point) const { return rotate(point) * scale + translate; }
    /// A point of the object in the world. [m]
    Vec3d point_to_world(const Vec3d& point) const {
        return rotate(point) * double(scale) + Vec3d(translate);
    }
    /// A direction or normal of the object in the world.
    Vec3f direction_to_world(const Vec3f& direction) const { return rotate(direction); }

    /// The inverse of point_to_world, up to rounding. [m]
    Vec3f point_to_object(const Vec3f& point) const { return rotate.back(point_to_turned(point)); }
    /// The inverse of direction_to_world, up to rounding.
    Vec3f direction_to_object(const Vec3f& direction) const { return rotate.back(direction); }

    /// To the frame of the object as it is turned, which is neither scaled nor translated. [m]
    Vec3f point_to_turned(const Vec3f& point) const { return (point - translate) / scale; }

    /// The map to the world as columns of three: where the axes go to, and the origin. What Embree takes.
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

    bool operator==(const Placement&) const = default;  ///< Equal in all bits.
};

}  // namespace haarfield
