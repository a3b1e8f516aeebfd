#pragma once
/// Where an object stands in the world.

#include "fields/base/vector.h"

namespace haarfield {

/// world = translate + scale * object.
///
/// Directions and normals are the same in both frames, distances in the world `scale` times as long. What is
/// turned, too, is turned first: world = translate + scale * rotate(object). That is the work of turned_mesh,
/// which makes an object of its own, with occluders and fields of its own; placed are only its results.
struct Placement {
    Vec3f translate{0, 0, 0};  ///< [m]
    float scale = 1;           ///< > 0, finite.

    /// A point of the object in the world. [m]
    Vec3f point_to_world(const Vec3f& point) const { return point * scale + translate; }
    /// A point of the object in the world. [m]
    Vec3d point_to_world(const Vec3d& point) const { return point * double(scale) + Vec3d(translate); }

    /// The inverse, up to rounding.
    Vec3f point_to_object(const Vec3f& point) const { return (point - translate) / scale; }

    bool operator==(const Placement&) const = default;  ///< Equal in all bits.
};

}  // namespace haarfield
