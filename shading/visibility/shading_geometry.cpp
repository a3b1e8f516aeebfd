#include "shading/visibility/shading_geometry.h"

#include <algorithm>
#include <limits>

#include "fields/base/parallel_loop.h"
#include "fields/base/spiral.h"
#include "fields/preparation/mesh_simplification.h"
#include "shading/scene/light_sources.h"

namespace haarfield {
namespace {

/// Greatest distance from an occluder's ground plane at which a vertex counts as on it. [radii of the
/// occluder]
constexpr float on_ground = 2e-3f;

/// Largest number of instances rasterized per vertex with Occlusion::automatic.
constexpr std::size_t most_rasterized = 8;

/// Least number of instances of a crowd.
constexpr std::size_t least_crowd = 16;

/// Returns the distance from a sampler's centre within which its entity is exact. With Occlusion::automatic,
/// this is the outer end of the last band whose error exceeds the tolerance. [m]
template <class Sampler>
float exact_distance(const Sampler& sampler, const SamplerError& error, Occlusion occlusion,
                     double tolerance) {
    if (occlusion == Occlusion::fields) return 0;
    std::size_t bands = SamplerError::bands;
    if (occlusion == Occlusion::automatic)
        while (bands > 0 && double(error.band[bands - 1]) <= tolerance) --bands;
    return static_cast<float>(
        distance_at(double(bands) / SamplerError::bands, sampler.outer_radius, sampler.growth));
}

/// Tests whether a box lies entirely below a plane through a point.
bool lies_below(const Bounds& bounds, const Vec3f& point, const Vec3f& normal) {
    float highest = 0;
    for (int axis = 0; axis < 3; ++axis)
        highest +=
            normal[axis] * ((normal[axis] > 0 ? bounds.upper[axis] : bounds.lower[axis]) - point[axis]);
    return highest <= 0;
}

/// Returns a placement's rotation as OccluderView expects it.
const Rotation* turn_of(const Placement& placement) {
    return is_identity(placement.rotate) ? nullptr : &placement.rotate;
}

bool is_on_ground(const VisibilityField& field, const ShadedInstance& instance, const ShadingPoint& at) {
    const float height = instance.placement.point_to_turned(at.position).y - field.planar.centre.y;
    return std::abs(height) <= on_ground * field.bounds.radius();
}

/// Prepares an instance in its placement.
ShadingGeometry::Instance placed_instance(const ShadedEntity& entity, const ShadingGeometry::Entity& prepared,
                                          const Placement& placement, bool is_crowd) {
    const Bounds& bounds = entity.occlusion->coarse().bounds();
    const bool is_turned = !is_identity(placement.rotate);
    const bool by_impostors = (is_turned || is_crowd) && prepared.polygons.empty();
    return {turned_polygons(prepared.polygons, placement.rotate), is_turned,
            placement.point_to_world(bounds.centre()), bounds.radius() * placement.scale,
            placement.scale *
                (by_impostors ? Impostors::nearest * bounds.radius() : entity.field->spherical.outer_radius)};
}

/// Tests whether an instance of an entity may be viewed by impostors from another instance.
bool needs_impostors(const ShadedScene& scene, const ShadingGeometry& geometry, std::size_t entity) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        if (scene.instances[i].entity != entity) continue;
        const ShadingGeometry::Instance& seen = geometry.instances[i];
        for (std::size_t k = 0; k < scene.instances.size(); ++k) {
            const ShadingGeometry::Instance& from = geometry.instances[k];
            const float distance = (from.middle - seen.middle).length();
            if (k != i && distance + from.radius > seen.nearer &&
                distance - from.radius < geometry.reach * seen.radius)
                return true;
        }
        // More rotated instances may be nearby than are rasterized.
        if (seen.is_turned && geometry.entities[entity].polygons.empty()) return true;
    }
    return false;
}

/// Returns the mean unoccluded fraction of cosine-weighted directions over the scene's surfaces, by rays from
/// a few vertices. 1 if there are none.
double mean_openness(const ShadedScene& scene, const ShadowRays& rays) {
    constexpr std::size_t wanted = 256;
    constexpr std::size_t directions = 64;
    std::size_t vertices = 0, asked = 0, open = 0;
    for (const ShadedInstance& instance : scene.instances)
        vertices += scene.entities[instance.entity].mesh->positions.size();
    const double step = std::max(1.0, double(vertices) / wanted);
    double next = step / 2;
    std::size_t first = 0;
    for (const ShadedInstance& instance : scene.instances) {
        const ShadedEntity& entity = scene.entities[instance.entity];
        const LocalSamples& samples = entity.occlusion->samples();
        for (; next < double(first + samples.points.size()); next += step) {
            const std::size_t vertex = static_cast<std::size_t>(next) - first;
            if (samples.buried[vertex]) continue;
            const Vec3f from = instance.placement.point_to_world(samples.points[vertex]);
            const Vec3d normal(instance.placement.direction_to_world(entity.mesh->normals[vertex]));
            const auto [across, up] = axes_across(normal);
            for (std::size_t k = 0; k < directions; ++k) {
                const Vec3d upright = spiral_direction(k, std::sqrt((double(k) + 0.5) / directions));
                open +=
                    !rays.is_blocked(from, Vec3f(across * upright.x + up * upright.y + normal * upright.z));
                ++asked;
            }
        }
        first += samples.points.size();
    }
    return asked > 0 ? double(open) / double(asked) : 1;
}

/// Prepares the occluders of one entity.
Result<ShadingGeometry::Entity> entity_geometry(const ShadedEntity& entity, const RenderSettings& settings,
                                                const Progress& progress) {
    std::vector<std::uint32_t> order = spatial_order(entity.mesh->positions);
    HF_TRY(WideVisibility visibility, WideVisibility::make(*entity.field, order, progress.stop));
    std::vector<ConvexPolygon> polygons;
    if (entity.occlusion->coarse().triangles().size() <= settings.exact_triangles)
        polygons = convex_polygons(entity.occlusion->coarse());
    return ShadingGeometry::Entity{std::move(order),
                                   std::move(visibility),
                                   std::move(polygons),
                                   0,
                                   0,
                                   BuriedFill(*entity.mesh, entity.occlusion->samples().buried),
                                   std::nullopt};
}

/// Makes simplifications of an occluder. Each is used from the distance at which its RMS distance from the
/// coarse mesh subtends a small part of a texel. None after a stop request.
std::vector<ShadingGeometry::Entity::Level> levels_of(const EntityOcclusion& occlusion, int face_size,
                                                      const std::stop_token& stop) {
    constexpr float largest_shift = 0.3f;  // texels
    std::vector<ShadingGeometry::Entity::Level> levels;
    const float shift = largest_shift * 2 / static_cast<float>(face_size);
    try {
        for (const CoarserMesh& coarser : occlusion.coarser({{}, stop}))
            levels.push_back({make_occluder(coarser.mesh), coarser.distance / shift});
    } catch (const Interrupted&) {
        levels.clear();
    }
    return levels;
}

/// Makes the levels of all entities that have none yet.
Result<Done> add_levels(const ShadedScene& scene, ShadingGeometry& geometry, const Progress& progress) {
    return parallel_loop({scene.entities.size()},
                         [&]() -> LoopBody {
                             return [&](std::size_t e) {
                                 if (!geometry.entities[e].levels)
                                     geometry.entities[e].levels = levels_of(
                                         *scene.entities[e].occlusion, geometry.face_size, progress.stop);
                             };
                         },
                         "simplifying", {{}, progress.stop});
}

}  // namespace

Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         const Progress& progress) {
    // Only the automatic mode uses it.
    const double uneven = settings.occlusion == Occlusion::automatic
                              ? unevenness(split_light(scene.environment, settings.sources).smooth)
                              : 1;
    return shading_geometry(scene, settings, uneven, progress);
}

Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         double uneven, const Progress& progress) {
    ShadingGeometry geometry{{},
                             settings.face_size,
                             settings.occlusion == Occlusion::automatic
                                 ? most_rasterized
                                 : std::numeric_limits<std::size_t>::max(),
                             settings.reach,
                             settings.occlusion == Occlusion::automatic,
                             false,
                             DirectionPyramid(settings.face_size),
                             {},
                             {},
                             InstanceGrid({}),
                             {},
                             {}};
    // An entity without samples must not be looked up.
    if (std::ranges::any_of(scene.entities,
                            [](const ShadedEntity& e) { return !e.field->has_surroundings(); }))
        geometry.most_rasterized = std::numeric_limits<std::size_t>::max();
    geometry.rays.build(scene);
    for (const ShadedEntity& entity : scene.entities) {
        HF_TRY(ShadingGeometry::Entity made, entity_geometry(entity, settings, progress));
        geometry.entities.push_back(std::move(made));
    }
    HF_TRY_DONE(place_instances(scene, geometry, progress));
    adapt_to_light(scene, settings, uneven, geometry);
    return geometry;
}

void adapt_to_light(const ShadedScene& scene, const RenderSettings& settings, double uneven,
                    ShadingGeometry& geometry) {
    // All light arrives through a window: the smaller the opening, the larger the effect of an error in it.
    constexpr double half_open = 0.5;
    double tolerance = 0;
    if (settings.occlusion == Occlusion::automatic) {
        if (!geometry.openness) geometry.openness = mean_openness(scene, geometry.rays);
        tolerance = double(settings.occlusion_error) / uneven * std::min(1.0, *geometry.openness / half_open);
    }
    for (std::size_t e = 0; e < scene.entities.size(); ++e) {
        const VisibilityField& field = *scene.entities[e].field;
        ShadingGeometry::Entity& entity = geometry.entities[e];
        if (!field.has_surroundings()) {
            entity.exact_on_ground = entity.exact_around = std::numeric_limits<float>::infinity();
            continue;
        }
        entity.exact_on_ground =
            exact_distance(field.planar, field.error.planar, settings.occlusion, tolerance);
        entity.exact_around =
            exact_distance(field.spherical, field.error.spherical, settings.occlusion, tolerance);
    }
}

Result<Done> place_instances(const ShadedScene& scene, ShadingGeometry& geometry, const Progress& progress) {
    if (geometry.simplifies && scene.instances.size() > 1)
        if (Result<Done> added = add_levels(scene, geometry, progress); !added) {
            for (ShadingGeometry::Entity& entity : geometry.entities) entity.levels.reset();
            return added;
        }
    const bool is_crowd = geometry.simplifies && scene.instances.size() >= least_crowd;
    std::vector<ShadingGeometry::Instance> instances;
    std::vector<Sphere> spheres;
    Bounds bounds;
    for (const ShadedInstance& instance : scene.instances) {
        instances.push_back(placed_instance(scene.entities[instance.entity],
                                            geometry.entities[instance.entity], instance.placement,
                                            is_crowd));
        const ShadingGeometry::Instance& placed = instances.back();
        spheres.push_back({placed.middle, geometry.reach * placed.radius});
        bounds.add(placed.middle, placed.radius);
    }
    std::swap(geometry.instances, instances);
    geometry.impostors.resize(scene.entities.size());
    for (std::size_t e = 0; e < scene.entities.size(); ++e) {
        if (geometry.impostors[e] || !needs_impostors(scene, geometry, e)) continue;
        Result<Impostors> made =
            Impostors::make(scene.entities[e].occlusion->coarse(), geometry.face_size, progress.stop);
        if (!made) {
            std::swap(geometry.instances, instances);
            return made.error();
        }
        geometry.impostors[e] = std::move(*made);
    }
    geometry.is_crowd = is_crowd;
    geometry.grid = InstanceGrid(spheres, bounds);
    geometry.rays.place(scene);
    geometry.openness.reset();
    return Done{};
}

std::vector<std::span<const std::uint32_t>> ShadingGeometry::orders() const {
    std::vector<std::span<const std::uint32_t>> result;
    for (const Entity& entity : entities) result.push_back(entity.order);
    return result;
}

FieldLookup field_lookup(const VisibilityField& field, const ShadedInstance& instance,
                         const ShadingPoint& at) {
    const Vec3f point = instance.placement.point_to_turned(at.outside);
    if (is_on_ground(field, instance, at)) return {true, field.planar.interpolation(point)};
    return {false, field.spherical.interpolation(point)};
}

bool is_below_horizon(const ShadedScene& scene, std::size_t instance, const ShadingPoint& at) {
    const auto& [entity, placement] = scene.instances[instance];
    const Bounds& bounds = scene.entities[entity].occlusion->coarse().bounds();
    if (is_identity(placement.rotate))
        return lies_below(bounds, placement.point_to_turned(at.outside), at.brdf.normal);
    return lies_below(bounds, placement.point_to_object(at.outside),
                      placement.direction_to_object(at.brdf.normal));
}

OccluderView own_view(const ShadedScene& scene, std::size_t instance, const Vec3f& sample,
                      const ShadingPoint& at) {
    const auto& [entity, placement] = scene.instances[instance];
    return {&scene.entities[entity].occlusion->own(), sample, &at.brdf.normal, turn_of(placement)};
}

const Occluder& occluder_for(const ShadedScene& scene, const ShadingGeometry& geometry, std::size_t instance,
                             const ShadingPoint& at) {
    const auto& [entity, placement] = scene.instances[instance];
    const ShadingGeometry::Instance& seen = geometry.instances[instance];
    const float distance = ((seen.middle - at.outside).length() - seen.radius) / placement.scale;
    const Occluder* best = &scene.entities[entity].occlusion->coarse();
    if (const auto& levels = geometry.entities[entity].levels)
        for (const ShadingGeometry::Entity::Level& level : *levels)
            if (distance >= level.nearest) best = &level.occluder;
    return *best;
}

OccluderView view_of(const ShadedScene& scene, std::size_t instance, const ShadingPoint& at) {
    const auto& [entity, placement] = scene.instances[instance];
    return {&scene.entities[entity].occlusion->coarse(), placement.point_to_object(at.outside), nullptr,
            turn_of(placement)};
}

InstanceOcclusion occlusion_of(const ShadedScene& scene, const ShadingGeometry& geometry,
                               std::size_t instance, const ShadingPoint& at) {
    const ShadingGeometry::Instance& seen = geometry.instances[instance];
    const ShadedInstance& placed = scene.instances[instance];
    const Vec3f to_middle = seen.middle - at.outside;
    const float squared_distance = to_middle.length2(), reach = geometry.reach * seen.radius;
    if (!(squared_distance < reach * reach) || to_middle.dot(at.brdf.normal) <= -seen.radius ||
        is_below_horizon(scene, instance, at))
        return {OcclusionKind::open};
    const float share = squared_distance / (seen.nearer * seen.nearer);
    if (share >= 1) return {OcclusionKind::distant};
    if (seen.is_turned || !seen.polygons.empty()) return {OcclusionKind::exact, share};

    const VisibilityField& field = *scene.entities[placed.entity].field;
    const ShadingGeometry::Entity& prepared = geometry.entities[placed.entity];
    const bool planar = is_on_ground(field, placed, at);
    const Vec3f from_centre = placed.placement.point_to_object(at.outside) -
                              (planar ? field.planar.centre : field.spherical.centre);
    const float exact_distance = planar ? prepared.exact_on_ground : prepared.exact_around,
                exact_share = from_centre.length2() / (exact_distance * exact_distance);
    // 0/0 is not below 1.
    return {exact_share < 1 ? OcclusionKind::exact : OcclusionKind::sampled, exact_share};
}

}  // namespace haarfield
