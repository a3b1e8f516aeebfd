#include "shading/bounces/fine_surface.h"

#include <cassert>

#include "fields/base/embree_rays.h"

namespace haarfield {

FineSurface::FineSurface(const ShadedScene& scene) {
    for (const ShadedEntity& entity : scene.entities)
        triangles_.add_entity(entity.mesh->positions, entity.mesh->triangles);
    place(scene);
}

std::optional<SurfaceHit> FineSurface::first_hit(const ShadedScene& scene, const Vec3f& from,
                                                 const Vec3f& direction) const {
    const std::optional<RTCRayHit> ray =
        nearest_hit(triangles_.scene(), embree_ray(from, direction, far_away));
    if (!ray) return std::nullopt;
    const std::uint32_t instance = ray->hit.instID[0];
    const bool is_back =
        outwards(*ray).dot(scene.instances[instance].placement.direction_to_object(direction)) > 0;
    return SurfaceHit{instance, ray->hit.primID, ray->hit.u, ray->hit.v, ray->ray.tfar, is_back};
}

FineSurface::Hits FineSurface::first_hits(const ShadedScene& scene, const Vec3f& from,
                                          std::span<const Vec3f> directions) const {
    assert(directions.size() <= packet);
    RTCRayHit16 rays;
    alignas(64) std::array<int, packet> valid;
    for (std::size_t i = 0; i < packet; ++i) {
        const Vec3f direction = i < directions.size() ? directions[i] : Vec3f(0, 1, 0);
        valid[i] = i < directions.size() ? -1 : 0;
        rays.ray.org_x[i] = from.x;
        rays.ray.org_y[i] = from.y;
        rays.ray.org_z[i] = from.z;
        rays.ray.dir_x[i] = direction.x;
        rays.ray.dir_y[i] = direction.y;
        rays.ray.dir_z[i] = direction.z;
        rays.ray.tnear[i] = rays.ray.time[i] = 0;
        rays.ray.tfar[i] = far_away;
        rays.ray.mask[i] = ~0u;
        rays.ray.id[i] = rays.ray.flags[i] = 0;
        rays.hit.geomID[i] = rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    find_hits(triangles_.scene(), valid.data(), rays, Coherence::none);
    Hits hits;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        if (rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        const std::uint32_t instance = rays.hit.instID[0][i];
        const Vec3f outwards(rays.hit.Ng_x[i], rays.hit.Ng_y[i], rays.hit.Ng_z[i]);
        const bool is_back =
            outwards.dot(scene.instances[instance].placement.direction_to_object(directions[i])) > 0;
        hits[i] =
            SurfaceHit{instance, rays.hit.primID[i], rays.hit.u[i], rays.hit.v[i], rays.ray.tfar[i], is_back};
    }
    return hits;
}

}  // namespace haarfield
