#pragma once
/// Single rays through Embree's scenes. Not a part of the libraries' interface: it needs Embree's headers.

#include <embree3/rtcore.h>

#include <optional>

#include "fields/base/vector.h"

namespace haarfield {

/// A ray from `from` along `direction`, as far as `range` times it; every mask lets it pass. [m]
inline RTCRay embree_ray(const Vec3f& from, const Vec3f& direction, float range) {
    RTCRay ray{};
    ray.org_x = from.x;
    ray.org_y = from.y;
    ray.org_z = from.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = range;
    ray.mask = ~0u;
    return ray;
}

/// Whether a ray meets anything that the scene's filters leave it.
inline bool meets_any(RTCScene scene, RTCRay ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &ray);
    return ray.tfar < 0;  // Embree's mark of a hit
}

/// The first that a ray meets.
inline std::optional<RTCRayHit> nearest_hit(RTCScene scene, const RTCRay& ray) {
    RTCRayHit result{ray, {}};
    result.hit.geomID = result.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &result);
    if (result.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return result;
}

/// The normal of the triangle that is met, in the frame of its own mesh: outwards, of any length.
inline Vec3f outwards(const RTCRayHit& ray) {
    return Vec3f(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z);
}

}  // namespace haarfield
