#include "shading/bounces/fine_surface.h"

#include "fields/base/embree_rays.h"

namespace haarfield {
namespace {

/// Converts Embree's hit to a SurfaceHit of instance 0.
///
/// direction  in the frame of the entity.
SurfaceHit surface_hit(const RTCRayHit& ray, const Vec3f& direction) {
    return {0, ray.hit.primID, ray.hit.u, ray.hit.v, ray.ray.tfar, outwards(ray).dot(direction) > 0};
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
    const ShadedInstance& instance = scene.instances[ray->hit.instID[0]];
    SurfaceHit hit = surface_hit(*ray, instance.placement.direction_to_object(direction));
    hit.instance = ray->hit.instID[0];
    return hit;
}

std::optional<SurfaceHit> FineSurface::below(std::size_t entity, const Vec3f& from,
                                             const Vec3f& normal) const {
    const Vec3f down = -normal;
    const std::optional<RTCRayHit> ray =
        nearest_hit(triangles_.entity(entity), embree_ray(from, down, far_away));
    if (!ray) return std::nullopt;
    return surface_hit(*ray, down);
}

}  // namespace haarfield
