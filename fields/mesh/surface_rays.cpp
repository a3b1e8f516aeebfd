#include "fields/mesh/surface_rays.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

/// Embree's normal has the triangle's own orientation, and any length: counter-clockwise seen from its tip.
void keep_steep_backs(const RTCFilterFunctionNArguments* query) {
    const auto* hit = reinterpret_cast<const RTCHit*>(query->hit);
    const auto* ray = reinterpret_cast<const RTCRay*>(query->ray);
    const Vec3f normal(hit->Ng_x, hit->Ng_y, hit->Ng_z), direction(ray->dir_x, ray->dir_y, ray->dir_z);
    if (normal.dot(direction) < std::sqrt(0.5f) * normal.length()) *query->valid = 0;
}

template <typename Ray>
void aim(Ray& ray, const Vec3f& from, const Vec3f& direction, float range) {
    ray.org_x = from.x;
    ray.org_y = from.y;
    ray.org_z = from.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = range;
    ray.mask = ~0u;
}

RTCRayHit nearest_hit(RTCScene scene, const Vec3f& from, const Vec3f& direction, float range) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray{};
    aim(ray.ray, from, direction, range);
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &ray);
    return ray;
}

}  // namespace

SurfaceRays::SurfaceRays(std::span<const Vec3f> positions,
                         std::span<const std::array<std::uint32_t, 3>> triangles)
    : device_("threads=1"), scene_(rtcNewScene(device_.get()), &rtcReleaseScene) {
    const std::shared_ptr<RTCGeometryTy> geometry = device_.triangles(positions, triangles);
    rtcSetGeometryOccludedFilterFunction(geometry.get(), &keep_steep_backs);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene_.get(), geometry.get());
    device_.commit(scene_.get());
}

float SurfaceRays::distance_to_back(const Vec3f& from, const Vec3f& direction, float range) const {
    const RTCRayHit ray = nearest_hit(scene_.get(), from, direction, range);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return 0;
    return Vec3f(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z).dot(direction) > 0 ? ray.ray.tfar : 0;
}

bool SurfaceRays::meets_surface(const Vec3f& from, const Vec3f& direction) const {
    // not rtcOccluded1, which the filter works for
    return nearest_hit(scene_.get(), from, direction, INFINITY).hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

bool SurfaceRays::passes_a_back(const Vec3f& from, const Vec3f& direction, float range) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay ray{};
    aim(ray, from, direction, range);
    rtcOccluded1(scene_.get(), &context, &ray);
    return ray.tfar < 0;  // Embree's mark of a hit
}

}  // namespace haarfield
