#include "fields/mesh/first_surface.h"

#include <cmath>

#include "fields/base/embree_rays.h"

namespace haarfield {

FirstSurface::FirstSurface(const Mesh& mesh) : scene_(rtcNewScene(device_.get()), &rtcReleaseScene) {
    const std::shared_ptr<RTCGeometryTy> geometry = device_.triangles(mesh.positions, mesh.triangles);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene_.get(), geometry.get());
    device_.commit(scene_.get());
}

std::optional<FirstSurface::Hit> FirstSurface::operator()(const Vec3f& from, const Vec3f& direction) const {
    const std::optional<RTCRayHit> ray = nearest_hit(scene_.get(), embree_ray(from, direction, INFINITY));
    if (!ray) return std::nullopt;
    return Hit{ray->hit.primID, outwards(*ray).dot(direction) < 0, ray->hit.u, ray->hit.v};
}

bool FirstSurface::is_met(const Vec3f& from, const Vec3f& way) const {
    return meets_any(scene_.get(), embree_ray(from, way, 1));
}

}  // namespace haarfield
