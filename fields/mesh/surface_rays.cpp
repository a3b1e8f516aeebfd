#include "fields/mesh/surface_rays.h"

#include <algorithm>
#include <cmath>

#include "fields/base/embree_rays.h"

namespace haarfield {
namespace {

/// Accepts hits of back faces at less than 45 degrees to the normal. Embree's normal has the triangle's
/// orientation and is not normalised: the triangle is counter-clockwise as viewed from its tip.
void keep_steep_backs(const RTCFilterFunctionNArguments* query) {
    const auto* hit = reinterpret_cast<const RTCHit*>(query->hit);
    const auto* ray = reinterpret_cast<const RTCRay*>(query->ray);
    const Vec3f normal(hit->Ng_x, hit->Ng_y, hit->Ng_z), direction(ray->dir_x, ray->dir_y, ray->dir_z);
    if (normal.dot(direction) < std::sqrt(0.5f) * normal.length()) *query->valid = 0;
}

}  // namespace

SurfaceRays::SurfaceRays(std::span<const Vec3f> positions,
                         std::span<const std::array<std::uint32_t, 3>> triangles)
    : scene_(rtcNewScene(device_.get()), &rtcReleaseScene) {
    const std::shared_ptr<RTCGeometryTy> geometry = device_.triangles(positions, triangles);
    rtcSetGeometryOccludedFilterFunction(geometry.get(), &keep_steep_backs);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene_.get(), geometry.get());
    device_.commit(scene_.get());
}

float SurfaceRays::distance_to_back(const Vec3f& from, const Vec3f& direction, float range) const {
    const std::optional<RTCRayHit> ray = nearest_hit(scene_.get(), embree_ray(from, direction, range));
    if (!ray) return 0;
    return outwards(*ray).dot(direction) > 0 ? ray->ray.tfar : 0;
}

bool SurfaceRays::meets_surface(const Vec3f& from, const Vec3f& direction) const {
    // rtcOccluded1 would use the filter
    return nearest_hit(scene_.get(), embree_ray(from, direction, INFINITY)).has_value();
}

bool SurfaceRays::passes_a_back(const Vec3f& from, const Vec3f& direction, float range) const {
    return meets_any(scene_.get(), embree_ray(from, direction, range));
}

}  // namespace haarfield
