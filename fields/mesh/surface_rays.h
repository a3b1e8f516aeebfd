#pragma once
/// Rays against triangles, where a few of them answer what no rasterizer would: Embree's work.

#include "fields/base/embree_device.h"
#include "fields/base/vector.h"

#include <array>
#include <memory>
#include <span>

struct RTCSceneTy;

namespace haarfield {

/// Safe to share between threads once made.
class SurfaceRays {
public:
    /// Copies what it needs.
    ///
    /// triangles  counter-clockwise seen from their front.
    SurfaceRays(std::span<const Vec3f> positions, std::span<const std::array<std::uint32_t, 3>> triangles);

    /// How far along a unit direction the first surface lies, if it is within a range and met from behind;
    /// 0 otherwise. [m]
    float distance_to_back(const Vec3f& from, const Vec3f& direction, float range) const;

    /// Whether any surface within a range is met from behind, at less than 45 degrees from its normal; what
    /// is met from the front is passed through.
    bool passes_a_back(const Vec3f& from, const Vec3f& direction, float range) const;

    /// Whether any surface lies in a direction, however far.
    bool meets_surface(const Vec3f& from, const Vec3f& direction) const;

private:
    EmbreeDevice device_;
    std::unique_ptr<RTCSceneTy, void (*)(RTCSceneTy*)> scene_;
};

}  // namespace haarfield
