#include "shading/shading_geometry.h"

#include <algorithm>

namespace haarfield {
namespace {

/// How far from an occluder's ground plane a vertex still counts as on it. [radii of the occluder]
constexpr float on_ground = 2e-3f;

/// How far from its sampler's centre an instance hides anything. [outer radii]
constexpr float reach = 1.5f;

}  // namespace

std::vector<Sphere> spheres_of_influence(const ShadedScene& scene) {
    std::vector<Sphere> spheres;
    for (const ShadedInstance& instance : scene.instances) {
        const VisibilityField& field = *scene.entities[instance.entity].field;
        const Vec3f& centre = field.spherical.centre;
        const float radius = reach * std::max(field.spherical.outer_radius, field.planar.outer_radius) +
                             (field.planar.centre - centre).length();
        spheres.push_back({instance.translate + centre * instance.scale, radius * instance.scale});
    }
    return spheres;
}

Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         const Progress& progress) {
    ShadingGeometry geometry{
        {}, DirectionPyramid(settings.face_size), InstanceGrid(spheres_of_influence(scene))};
    for (const ShadedEntity& entity : scene.entities) {
        std::vector<std::uint32_t> order = spatial_order(entity.mesh->positions);
        Result<WideVisibility> visibility = WideVisibility::make(*entity.field, order, progress.stop);
        if (!visibility) return visibility.error();
        std::vector<ConvexPolygon> polygons;
        if (entity.occlusion->coarse().triangles.size() <= settings.exact_triangles)
            polygons = convex_polygons(entity.occlusion->coarse());
        geometry.entities.push_back({std::move(order), std::move(*visibility), std::move(polygons)});
    }
    return geometry;
}

FieldLookup field_lookup(const VisibilityField& field, const ShadedInstance& instance,
                         const VertexView& view) {
    const Vec3f point = (view.point - instance.translate) / instance.scale;
    const float height = (view.position.y - instance.translate.y) / instance.scale - field.planar.centre.y;
    if (std::abs(height) <= on_ground * field.bounds.radius())
        return {true, field.planar.interpolation(point)};
    return {false, field.spherical.interpolation(point)};
}

bool VertexVisibility::look(std::size_t instance_index, const WideCubemap<std::uint8_t>& own,
                            const VertexView& view) {
    trees_.clear();
    parts_.clear();
    cones_.clear();
    const std::span<const std::uint32_t> near = geometry_.grid.near(view.point);
    parts_.reserve(1 + 8 * near.size());  // so that spans of them stay
    const auto add_tree = [&](const WideCubemap<std::uint8_t>& tree, float weight) {
        parts_.push_back({&tree, weight});
        trees_.back().parts = {parts_.data() + parts_.size() - trees_.back().parts.size() - 1,
                               trees_.back().parts.size() + 1};
    };
    trees_.emplace_back();
    add_tree(own, 1);
    for (const std::uint32_t i : near) {
        if (i == instance_index) continue;
        const ShadedInstance& other = scene_.instances[i];
        const ShadedEntity& entity = scene_.entities[other.entity];
        const ShadingGeometry::Entity& prepared = geometry_.entities[other.entity];
        const Vec3f point = (view.point - other.translate) / other.scale;
        const VisibilityField& field = *entity.field;
        if (!prepared.polygons.empty() && (point - field.spherical.centre).length2() <
                                              field.spherical.outer_radius * field.spherical.outer_radius) {
            if (entity.occlusion->coarse().one_sided > 0 && entity.occlusion->in_coarse()(point))
                return false;
            add_cones(prepared.polygons, point, cones_);
            continue;
        }
        const auto [planar, samples] = field_lookup(field, other, view);
        if (samples.count == 0) continue;
        trees_.emplace_back().constant = samples.open;
        for (std::size_t k = 0; k < std::size_t(samples.count); ++k)
            add_tree(planar ? prepared.visibility.planar(samples.sample[k])
                            : prepared.visibility.spherical(samples.sample[k]),
                     samples.weight[k]);
    }
    return true;
}

}  // namespace haarfield
