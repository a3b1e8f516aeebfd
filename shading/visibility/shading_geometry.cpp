#include "shading/visibility/shading_geometry.h"

#include <algorithm>
#include <limits>

namespace haarfield {
namespace {

/// How far from an occluder's ground plane a vertex still counts as on it. [radii of the occluder]
constexpr float on_ground = 2e-3f;

/// So many instances are rasterized at a vertex, if that is chosen automatically.
constexpr std::size_t most_rasterized = 8;

/// How far away what is seen exactly at any distance is seen at all: from there a ball blocks less than a
/// thousandth of an irradiance. [radii]
constexpr float exact_reach = 36;

/// How far from a sampler's centre its entity is seen exactly: automatically, to the outer end of the last
/// band whose error is above the tolerance. [m]
template <class Sampler>
float exact_distance(const Sampler& sampler, const SamplerError& error, Occlusion occlusion,
                     float tolerance) {
    if (occlusion == Occlusion::fields) return 0;
    std::size_t bands = SamplerError::bands;
    if (occlusion == Occlusion::automatic)
        while (bands > 0 && error.band[bands - 1] <= tolerance) --bands;
    return static_cast<float>(
        distance_at(double(bands) / SamplerError::bands, sampler.outer_radius, sampler.growth));
}

/// Whether a box lies wholly below a plane through a point.
bool lies_below(const Bounds& bounds, const Vec3f& point, const Vec3f& normal) {
    float highest = 0;
    for (int axis = 0; axis < 3; ++axis)
        highest +=
            normal[axis] * ((normal[axis] > 0 ? bounds.upper[axis] : bounds.lower[axis]) - point[axis]);
    return highest <= 0;
}

bool is_on_ground(const VisibilityField& field, const ShadedInstance& instance, const VertexView& view) {
    const float height = instance.placement.point_to_object(view.position).y - field.planar.centre.y;
    return std::abs(height) <= on_ground * field.bounds.radius();
}

}  // namespace

InstanceGrid influence_grid(const ShadedScene& scene, std::span<const ShadingGeometry::Entity> entities) {
    std::vector<Sphere> spheres;
    Bounds bounds;
    for (const ShadedInstance& instance : scene.instances) {
        const VisibilityField& field = *scene.entities[instance.entity].field;
        const Vec3f &own = field.spherical.centre, centre = instance.placement.point_to_world(own);
        const float scale = instance.placement.scale,
                    samplers = fade_end * std::max(field.spherical.outer_radius, field.planar.outer_radius) +
                               (field.planar.centre - own).length(),
                    radius = entities[instance.entity].polygons.empty() ? samplers
                                                                        : exact_reach * field.bounds.radius();
        spheres.push_back({centre, radius * scale});
        const Vec3f half(field.bounds.radius() * scale);
        for (int axis = 0; axis < 3; ++axis) {
            bounds.lower[axis] = std::min(bounds.lower[axis], centre[axis] - half[axis]);
            bounds.upper[axis] = std::max(bounds.upper[axis], centre[axis] + half[axis]);
        }
    }
    return InstanceGrid(spheres, bounds);
}

Result<ShadingGeometry::Entity> entity_geometry(const ShadedEntity& entity, const RenderSettings& settings,
                                                const Progress& progress) {
    std::vector<std::uint32_t> order = spatial_order(entity.mesh->positions);
    Result<WideVisibility> visibility = WideVisibility::make(*entity.field, order, progress.stop);
    if (!visibility) return visibility.error();
    std::vector<ConvexPolygon> polygons;
    if (entity.occlusion->coarse().triangles().size() <= settings.exact_triangles)
        polygons = convex_polygons(entity.occlusion->coarse());
    const VisibilityField& field = *entity.field;
    const auto exact_within = [&](const auto& sampler, const SamplerError& error) {
        return polygons.empty() ? exact_distance(sampler, error, settings.occlusion, settings.occlusion_error)
                                : std::numeric_limits<float>::infinity();
    };
    const float on_ground = exact_within(field.planar, field.error.planar),
                around = exact_within(field.spherical, field.error.spherical);
    return ShadingGeometry::Entity{std::move(order),
                                   std::move(*visibility),
                                   std::move(polygons),
                                   on_ground,
                                   around,
                                   BuriedFill(*entity.mesh, entity.occlusion->samples().buried)};
}

Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         const Progress& progress) {
    ShadingGeometry geometry{{},
                             settings.face_size,
                             settings.occlusion == Occlusion::automatic
                                 ? most_rasterized
                                 : std::numeric_limits<std::size_t>::max(),
                             DirectionPyramid(settings.face_size),
                             InstanceGrid({}),
                             {}};
    geometry.rays.build(scene);
    for (const ShadedEntity& entity : scene.entities) {
        Result<ShadingGeometry::Entity> made = entity_geometry(entity, settings, progress);
        if (!made) return made.error();
        geometry.entities.push_back(std::move(*made));
    }
    geometry.grid = influence_grid(scene, geometry.entities);
    return geometry;
}

std::vector<std::span<const std::uint32_t>> ShadingGeometry::orders() const {
    std::vector<std::span<const std::uint32_t>> result;
    for (const Entity& entity : entities) result.push_back(entity.order);
    return result;
}

FieldLookup field_lookup(const VisibilityField& field, const ShadedInstance& instance,
                         const VertexView& view) {
    const Vec3f point = instance.placement.point_to_object(view.point);
    if (is_on_ground(field, instance, view)) return {true, field.planar.interpolation(point)};
    return {false, field.spherical.interpolation(point)};
}

bool is_below_horizon(const ShadedEntity& entity, const ShadedInstance& instance, const VertexView& view) {
    return lies_below(entity.occlusion->coarse().bounds(), instance.placement.point_to_object(view.point),
                      view.normal);
}

float squared_exact_distance(const ShadingGeometry::Entity& prepared, const VisibilityField& field,
                             const ShadedInstance& instance, const VertexView& view) {
    const Vec3f point = instance.placement.point_to_object(view.point);
    const bool planar = is_on_ground(field, instance, view);
    const Vec3f from_centre = point - (planar ? field.planar.centre : field.spherical.centre);
    const float exact_distance = planar ? prepared.exact_on_ground : prepared.exact_around;
    return from_centre.length2() / (exact_distance * exact_distance);
}

}  // namespace haarfield
