#include "shading/bounces/fine_surface.h"

#include <cassert>

#include "fields/base/embree_rays.h"
#include "shading/visibility/shadow_rays.h"

namespace haarfield {
namespace {

/// Returns a hit of a ray.
///
/// outwards   the normal of the triangle in its mesh's frame, of any length.
/// direction  of the ray, in the world.
SurfaceHit surface_hit(const ShadedScene& scene, std::uint32_t instance, std::uint32_t triangle, float u,
                       float v, float distance, const Vec3f& outwards, const Vec3f& direction) {
    const Placement& placement = scene.instances[instance].placement;
    const bool is_back = outwards.dot(placement.direction_to_object(direction)) > 0;
    return {instance, triangle, u, v, distance, is_back};
}

}  // namespace

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
    const RTCHit& hit = ray->hit;
    return surface_hit(scene, hit.instID[0], hit.primID, hit.u, hit.v, ray->ray.tfar, outwards(*ray),
                       direction);
}

FineSurface::Hits FineSurface::first_hits(const ShadedScene& scene, const Vec3f& from,
                                          std::span<const Vec3f> directions) const {
    assert(directions.size() <= packet);
    static_assert(packet == packet_rays);
    Hits hits;
    if (directions.empty()) return hits;
    RTCRayHit16 rays;
    alignas(64) std::array<int, packet> valid;
    for (std::size_t i = 0; i < packet; ++i) {
        valid[i] = i < directions.size() ? -1 : 0;
        set_ray(rays.ray, i, from, i < directions.size() ? directions[i] : Vec3f(0, 1, 0), far_away);
    }
    find_hits(triangles_.scene(), valid.data(), rays, Coherence::none);
    const RTCHit16& hit = rays.hit;
    for (std::size_t i = 0; i < directions.size(); ++i)
        if (hit.geomID[i] != RTC_INVALID_GEOMETRY_ID)
            hits[i] =
                surface_hit(scene, hit.instID[0][i], hit.primID[i], hit.u[i], hit.v[i], rays.ray.tfar[i],
                            Vec3f(hit.Ng_x[i], hit.Ng_y[i], hit.Ng_z[i]), directions[i]);
    return hits;
}

std::uint16_t FineSurface::hidden(const Vec3f& from, std::span<const Vec3f> ends) const {
    assert(ends.size() <= packet);
    return blocked_rays(
        triangles_.scene(), static_cast<std::uint16_t>((1u << ends.size()) - 1),
        [&](std::size_t) { return from; }, [&](std::size_t i) { return ends[i] - from; },
        1 - ShadowRays::last_part);
}

}  // namespace haarfield
