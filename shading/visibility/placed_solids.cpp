#include "shading/visibility/placed_solids.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace haarfield {
namespace {

bool contains(const Occluder& occluder, const InsideTest& is_inside, const Vec3f& point) {
    if (occluder.one_sided() == 0) return false;
    const Bounds& bounds = occluder.bounds();
    for (int axis = 0; axis < 3; ++axis)
        if (!(point[axis] > bounds.lower[axis] && point[axis] < bounds.upper[axis])) return false;
    return is_inside(point);
}

/// Returns the sphere around the original and the coarse mesh of a solid, in the world.
Sphere sphere_of(const Placement& placement, const EntityOcclusion& occlusion) {
    Bounds bounds = occlusion.original().bounds();
    bounds.add(occlusion.coarse().bounds().lower);
    bounds.add(occlusion.coarse().bounds().upper);
    return {placement.point_to_world(bounds.centre()), bounds.radius() * placement.scale};
}

}  // namespace

std::vector<PlacedSolids::Solid> PlacedSolids::solids(const ShadedScene& scene) {
    std::vector<Solid> result;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const EntityOcclusion& occlusion = *scene.entities[scene.instances[i].entity].occlusion;
        if (occlusion.original().one_sided() > 0 || occlusion.coarse().one_sided() > 0)
            result.push_back({i, scene.instances[i].placement, &occlusion});
    }
    return result;
}

std::vector<Sphere> PlacedSolids::spheres(std::span<const Solid> solids) {
    std::vector<Sphere> result;
    for (const Solid& solid : solids) result.push_back(sphere_of(solid.placement, *solid.occlusion));
    return result;
}

PlacedSolids::PlacedSolids(const ShadedScene& scene) : solids_(solids(scene)), grid_(spheres(solids_)) {}

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

bool PlacedSolids::contain(const ShadedScene& scene, std::size_t instance, const SurfacePoint& point) const {
    if (solids_.empty()) return false;
    const ShadedInstance& placed = scene.instances[instance];
    // Occlusion by other instances is evaluated next to the sample.
    return contain(placed.placement.point_to_world(point.sample), instance) ||
           contain(shading_point(scene, placed, point).outside, instance);
}

std::vector<std::uint8_t> PlacedSolids::buried_vertices(const ShadedScene& scene, std::size_t instance,
                                                        const Mesh& mesh, const LocalSamples& samples) const {
    std::vector<std::uint8_t> buried = samples.buried;
    if (std::ranges::all_of(solids_, [&](const Solid& solid) { return solid.instance == instance; }))
        return buried;
    tbb::parallel_for(std::size_t(0), buried.size(), [&](std::size_t v) {
        if (!buried[v])
            buried[v] =
                contain(scene, instance,
                        {mesh.positions[v], mesh.normals[v], samples.points[v], mesh.vertex_materials[v]});
    });
    return buried;
}

PlacedFill::PlacedFill(const ShadedScene& scene) : fills_(scene.instances.size()) {
    const PlacedSolids solids(scene);
    for (std::size_t i = 0; i < fills_.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        const LocalSamples& samples = entity.occlusion->samples();
        const std::vector<std::uint8_t> buried = solids.buried_vertices(scene, i, *entity.mesh, samples);
        if (buried != samples.buried) fills_[i].emplace(*entity.mesh, buried);
    }
}

void PlacedFill::add_sources(VertexMask& is_chosen) const {
    for (std::size_t i = 0; i < fills_.size(); ++i)
        if (fills_[i]) fills_[i]->add_sources(is_chosen[i]);
}

}  // namespace haarfield
