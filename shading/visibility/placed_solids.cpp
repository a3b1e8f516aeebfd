#include "shading/visibility/placed_solids.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "shading/scene/vertex_loop.h"

namespace haarfield {
namespace {

bool contains(const Occluder& occluder, const InsideTest& is_inside, const Vec3f& point) {
    if (occluder.one_sided() == 0) return false;
    const Bounds& bounds = occluder.bounds();
    for (int axis = 0; axis < 3; ++axis)
        if (!(point[axis] > bounds.lower[axis] && point[axis] < bounds.upper[axis])) return false;
    return is_inside(point);
}

std::vector<Sphere> spheres(const ShadedScene& scene, std::span<const std::size_t> instances) {
    std::vector<Sphere> result;
    for (const std::size_t i : instances) {
        const ShadedInstance& instance = scene.instances[i];
        const EntityOcclusion& occlusion = *scene.entities[instance.entity].occlusion;
        Bounds bounds = occlusion.original().bounds();
        bounds.add(occlusion.coarse().bounds().lower);
        bounds.add(occlusion.coarse().bounds().upper);
        result.push_back(
            {instance.placement.point_to_world(bounds.centre()), bounds.radius() * instance.placement.scale});
    }
    return result;
}

std::vector<std::size_t> solid_instances(const ShadedScene& scene) {
    std::vector<std::size_t> result;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const EntityOcclusion& occlusion = *scene.entities[scene.instances[i].entity].occlusion;
        if (occlusion.original().one_sided() > 0 || occlusion.coarse().one_sided() > 0) result.push_back(i);
    }
    return result;
}

}  // namespace

PlacedSolids::PlacedSolids(const ShadedScene& scene) : grid_(spheres(scene, solid_instances(scene))) {
    for (const std::size_t i : solid_instances(scene))
        solids_.push_back(
            {i, scene.instances[i].placement, scene.entities[scene.instances[i].entity].occlusion});
}

bool PlacedSolids::contain(const Vec3f& point, std::size_t instance) const {
    return std::ranges::any_of(grid_.near(point), [&](std::uint32_t number) {
        const Solid& solid = solids_[number];
        if (solid.instance == instance) return false;
        const Vec3f at = solid.placement.point_to_object(point);
        const EntityOcclusion& occlusion = *solid.occlusion;
        return contains(occlusion.original(), occlusion.in_original(), at) ||
               contains(occlusion.coarse(), occlusion.in_coarse(), at);
    });
}

std::vector<std::uint8_t> buried_vertices(const PlacedSolids& solids, const ShadedScene& scene,
                                          std::size_t instance, const LocalSamples& samples) {
    std::vector<std::uint8_t> buried = samples.buried;
    const ShadedInstance& placed = scene.instances[instance];
    tbb::parallel_for(std::size_t(0), buried.size(), [&](std::size_t v) {
        if (buried[v]) return;
        const Vec3f& sample = samples.points[v];
        // Other instances are seen from a point beside the sample.
        const Vec3f from = vertex_view(scene, placed, SurfacePoint{sample, Vec3f(0, 1, 0), sample}).point;
        buried[v] = solids.contain(placed.placement.point_to_world(sample), instance) ||
                    solids.contain(from, instance);
    });
    return buried;
}

}  // namespace haarfield
