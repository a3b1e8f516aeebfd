#include "shading/shading_geometry.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace haarfield {
namespace {

/// How far from an occluder's ground plane a vertex still counts as on it. [radii of the occluder]
constexpr float on_ground = 2e-3f;

/// So many instances are rasterized at a vertex, if that is chosen automatically.
constexpr std::size_t most_rasterized = 8;

/// How far from its sampler's centre an instance hides anything. [outer radii]
constexpr float reach = 1.5f;

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
    const float height = (view.position.y - instance.translate.y) / instance.scale - field.planar.centre.y;
    return std::abs(height) <= on_ground * field.bounds.radius();
}

/// How far a vertex is from an instance, squared; less than 1 where it sees it exactly.
float squared_exact_distance(const ShadingGeometry::Entity& prepared, const VisibilityField& field,
                             const ShadedInstance& instance, const VertexView& view) {
    const Vec3f point = (view.point - instance.translate) / instance.scale;
    const bool planar = is_on_ground(field, instance, view);
    const Vec3f from_centre = point - (planar ? field.planar.centre : field.spherical.centre);
    const float exact_distance = planar ? prepared.exact_on_ground : prepared.exact_around;
    return from_centre.length2() / (exact_distance * exact_distance);
}

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

Result<ShadingGeometry::Entity> entity_geometry(const ShadedEntity& entity, const RenderSettings& settings,
                                                const Progress& progress) {
    std::vector<std::uint32_t> order = spatial_order(entity.mesh->positions);
    Result<WideVisibility> visibility = WideVisibility::make(*entity.field, order, progress.stop);
    if (!visibility) return visibility.error();
    std::vector<ConvexPolygon> polygons;
    if (entity.occlusion->coarse().triangles.size() <= settings.exact_triangles)
        polygons = convex_polygons(entity.occlusion->coarse());
    const Occlusion occlusion = polygons.empty() ? settings.occlusion : Occlusion::exact;
    const VisibilityField& field = *entity.field;
    return ShadingGeometry::Entity{
        std::move(order),
        std::move(*visibility),
        std::move(polygons),
        exact_distance(field.planar, field.error.planar, occlusion, settings.occlusion_error),
        exact_distance(field.spherical, field.error.spherical, occlusion, settings.occlusion_error),
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
                             InstanceGrid(spheres_of_influence(scene))};
    for (const ShadedEntity& entity : scene.entities) {
        Result<ShadingGeometry::Entity> made = entity_geometry(entity, settings, progress);
        if (!made) return made.error();
        geometry.entities.push_back(std::move(*made));
    }
    return geometry;
}

FieldLookup field_lookup(const VisibilityField& field, const ShadedInstance& instance,
                         const VertexView& view) {
    const Vec3f point = (view.point - instance.translate) / instance.scale;
    if (is_on_ground(field, instance, view)) return {true, field.planar.interpolation(point)};
    return {false, field.spherical.interpolation(point)};
}

void VertexVisibility::add_tree(const WideCubemap<std::uint8_t>& tree, float weight) {
    parts_.push_back({&tree, weight});
    const std::size_t count = trees_.back().parts.size() + 1;
    trees_.back().parts = {parts_.data() + parts_.size() - count, count};
}

bool VertexVisibility::look(std::size_t instance_index, const WideCubemap<std::uint8_t>& own,
                            const VertexView& view) {
    trees_.clear();
    parts_.clear();
    cones_.clear();
    candidates_.clear();
    const std::span<const std::uint32_t> near = geometry_.grid.near(view.point);
    parts_.reserve(2 + 8 * near.size());  // so that spans of them stay
    trees_.emplace_back();
    add_tree(own, 1);
    for (const std::uint32_t i : near)
        if (i != instance_index && !look_past(i, view)) return false;
    if (!candidates_.empty()) rasterize(view);
    return true;
}

bool is_below_horizon(const ShadedEntity& entity, const ShadedInstance& instance, const VertexView& view) {
    return lies_below(entity.occlusion->coarse().bounds, (view.point - instance.translate) / instance.scale,
                      view.normal);
}

bool is_seen_exactly(const ShadingGeometry::Entity& prepared, const VisibilityField& field,
                     const ShadedInstance& instance, const VertexView& view) {
    return squared_exact_distance(prepared, field, instance, view) < 1;
}

bool VertexVisibility::look_past(std::uint32_t instance, const VertexView& view) {
    const ShadedInstance& other = scene_.instances[instance];
    const ShadedEntity& entity = scene_.entities[other.entity];
    const ShadingGeometry::Entity& prepared = geometry_.entities[other.entity];
    const VisibilityField& field = *entity.field;
    if (is_below_horizon(entity, other, view)) return true;

    const float distance = squared_exact_distance(prepared, field, other, view);
    if (!(distance < 1) || (prepared.polygons.empty() && !rasterizes_)) {
        look_up(other, view);
        return true;
    }
    const Vec3f point = (view.point - other.translate) / other.scale;
    if (entity.occlusion->coarse().one_sided > 0 && entity.occlusion->in_coarse()(point)) return false;
    if (prepared.polygons.empty())
        candidates_.push_back({distance, instance});
    else
        add_cones(prepared.polygons, point, cones_);
    return true;
}

void VertexVisibility::look_up(const ShadedInstance& other, const VertexView& view) {
    const WideVisibility& visibility = geometry_.entities[other.entity].visibility;
    const auto [planar, samples] = field_lookup(*scene_.entities[other.entity].field, other, view);
    if (samples.count == 0) return;
    trees_.emplace_back().constant = samples.open;
    for (std::size_t k = 0; k < std::size_t(samples.count); ++k)
        add_tree(planar ? visibility.planar(samples.sample[k]) : visibility.spherical(samples.sample[k]),
                 samples.weight[k]);
}

void VertexVisibility::rasterize(const VertexView& view) {
    if (candidates_.size() > geometry_.most_rasterized) {
        const auto end = candidates_.begin() + std::ptrdiff_t(geometry_.most_rasterized);
        std::nth_element(candidates_.begin(), end, candidates_.end(),
                         [](const Candidate& a, const Candidate& b) {
                             return std::tie(a.distance, a.instance) < std::tie(b.distance, b.instance);
                         });
        for (auto farther = end; farther != candidates_.end(); ++farther)
            look_up(scene_.instances[farther->instance], view);
        candidates_.erase(end, candidates_.end());
    }
    rasterized_.clear();
    for (const Candidate& candidate : candidates_) {
        const ShadedInstance& other = scene_.instances[candidate.instance];
        const Occluder& occluder = scene_.entities[other.entity].occlusion->coarse();
        const Vec3f point = (view.point - other.translate) / other.scale;
        // Finding what lies below the horizon has a cost, too.
        const bool mostly_below = (occluder.bounds.centre() - point).dot(view.normal) < 0;
        rasterized_.push_back({&occluder, point, mostly_below ? &view.normal : nullptr});
    }
    trees_.emplace_back();
    add_tree(seen_(rasterized_), 1);
}

}  // namespace haarfield
