#pragma once
/// Ray queries against triangles, for tasks in which few rays suffice. Implemented with Embree.

#include "fields/base/embree_device.h"
#include "fields/base/vector.h"

#include <array>
#include <memory>
#include <span>

struct RTCSceneTy;

namespace haarfield {

/// A BVH of triangles. Safe to share between threads.
class SurfaceRays {
public:
    /// Copies the required data.
    ///
    /// triangles  counter-clockwise as viewed from their front.
    SurfaceRays(std::span<const Vec3f> positions, std::span<const std::array<std::uint32_t, 3>> triangles);

    /// Returns the distance to the first surface along a unit direction, if that is within the range and is
    /// hit from behind; otherwise 0. [m]
    float distance_to_back(const Vec3f& from, const Vec3f& direction, float range) const;

    /// Tests whether any surface within the range is hit from behind, at less than 45 degrees to its normal.
    /// Front faces are ignored.
    bool passes_a_back(const Vec3f& from, const Vec3f& direction, float range) const;

    /// Tests whether there is any surface in a direction, at any distance.
    bool meets_surface(const Vec3f& from, const Vec3f& direction) const;

private:
    EmbreeDevice device_;
    std::unique_ptr<RTCSceneTy, void (*)(RTCSceneTy*)> scene_;
};

}  // namespace haarfield
