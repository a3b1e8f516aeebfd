#include "shading/bounces/fine_surface.h"

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

}  // namespace haarfield
