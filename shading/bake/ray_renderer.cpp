#include "shading/bake/ray_renderer.h"

#include <tbb/parallel_for.h>

#include <cassert>

#include "fields/base/embree_rays.h"
#include "shading/bake/lamp_light.h"
#include "shading/bake/path_tracer.h"
#include "shading/bake/scrambled_sobol.h"
#include "shading/bake/shadow_batch.h"
#include "shading/bake/source_light.h"
#include "shading/bake/vertex_evaluation.h"
#include "shading/bounces/lobe_rays.h"

namespace haarfield {
namespace {

/// The number of samples of each technique.
struct Counts {
    std::uint32_t environment = 0, emitters = 0, cosine = 0;
    std::array<std::uint32_t, most_lobes> lobes{};
};

enum Technique : std::uint32_t { by_environment, by_emitters, by_cosine, by_lobes };

/// Divides the samples: each light technique gets twice as many as each term of the BRDF.
Counts counts_of(const RayScene& rays, const VertexBrdf& brdf, std::uint32_t samples) {
    Counts counts;
    if (!rays.environment.is_black()) counts.environment = 2;
    if (!rays.emitters.is_black()) counts.emitters = 2;
    counts.cosine = brdf.diffuse != Rgb(0.0f);
    std::uint32_t all = counts.environment + counts.emitters + counts.cosine;
    for (std::size_t i = 0; i < counts.lobes.size(); ++i)
        all += counts.lobes[i] = brdf.has_specular() && brdf.lobes[i].weight > 0;
    const auto divide = [&](std::uint32_t& count) {
        if (count > 0) count = std::max(1u, std::uint32_t(std::uint64_t(samples) * count / all));
    };
    for (std::uint32_t* count : {&counts.environment, &counts.emitters, &counts.cosine}) divide(*count);
    for (std::uint32_t& count : counts.lobes) divide(count);
    return counts;
}

/// The samples of direct light, by technique. Those of a technique are ordered along a curve.
struct DirectSamples {
    std::vector<LightSample> environment;
    std::vector<std::array<double, 2>> emitters;
    std::vector<Vec3f> cosine;  ///< About the z axis.
    std::array<std::vector<Vec2f>, most_lobes> lobes;
};

DirectSamples direct_samples(const RayScene& rays, const Counts& counts, std::uint32_t seed) {
    const auto places = [&](std::uint32_t technique, std::uint32_t count) {
        return sorted_points(ScrambledSobol(mixed_seed(seed, technique)), count);
    };
    DirectSamples samples;
    samples.environment.reserve(counts.environment);
    for (const std::array<double, 2>& place : places(by_environment, counts.environment))
        samples.environment.push_back(rays.environment.sample(place));
    samples.emitters = places(by_emitters, counts.emitters);
    const Vec3f up(0, 0, 1);
    const Axes<Vec3f> across{{1, 0, 0}, {0, 1, 0}};
    samples.cosine.reserve(counts.cosine);
    for (const std::array<double, 2>& place : places(by_cosine, counts.cosine))
        samples.cosine.push_back(cosine_direction(as_place(place), up, across));
    for (std::uint32_t i = 0; i < most_lobes; ++i)
        for (const std::array<double, 2>& place : places(by_lobes + i, counts.lobes[i]))
            samples.lobes[i].push_back(as_place(place));
    return samples;
}

/// Estimates the integral over the directions above one point.
class PointIntegral {
public:
    PointIntegral(const RayScene& rays, const VertexBrdf& brdf, const Vec3f& from, const Counts& counts)
        : rays_(rays),
          brdf_(brdf),
          from_(from),
          counts_(counts),
          lobes_(brdf),
          normal_axes_(axes_across(brdf.normal)),
          batch_(rays.rays, Add{*this}) {}
    PointIntegral(const PointIntegral&) = delete;
    PointIntegral& operator=(const PointIntegral&) = delete;

    Components<Vec3d> operator()(const DirectSamples& samples) {
        if (counts_.environment == 0 && counts_.emitters == 0) return {};
        for (const LightSample& light : samples.environment)
            if (brdf_.normal.dot(light.direction) > 0)
                batch_.add(from_, light.direction, far_away,
                           {light.direction, light.radiance, counts_.environment * light.density,
                            light.is_disc, false});
        for (const std::array<double, 2>& place : samples.emitters)
            if (const std::optional<LightSample> light = rays_.emitters.sample(from_, place))
                add_emitter(*light);
        for (const Vec3f& d : samples.cosine)
            add_direction(normal_axes_.across * d.x + normal_axes_.up * d.y + brdf_.normal * d.z);
        for (std::size_t i = 0; i < samples.lobes.size(); ++i)
            for (const Vec2f& place : samples.lobes[i])
                add_direction(lobes_.direction(brdf_.lobes[i], place).normalized());
        batch_.trace();
        return sum_;
    }

private:
    /// Light in a direction.
    struct Light {
        Vec3f direction{0.0f};
        Rgb radiance{0.0f};
        double density = 0;  ///< Of sampling the direction as one of light, times the number of samples.
        bool is_disc = false;
        bool is_unknown = false;  ///< The environment must be looked up.
    };
    struct Add {
        PointIntegral& integral;
        void operator()(const Light& light) const { integral.add(light); }
    };

    /// Adds unblocked light by the balance heuristic.
    void add(Light light) {
        if (light.is_unknown) {
            rays_.environment.look_up(light.direction, light.radiance, light.density);
            light.density *= counts_.environment;
        }
        const double densities = light.density + (light.is_disc ? 0.0 : brdf_density(light.direction));
        if (densities > 0)
            sum_ += Components<Vec3d>(reflectance(brdf_, light.direction) * light.radiance) * (1 / densities);
    }

    void add_emitter(const LightSample& light) {
        if (brdf_.normal.dot(light.direction) > 0)
            batch_.add(from_, light.direction, light.distance,
                       {light.direction, light.radiance, counts_.emitters * light.density, false, false});
    }

    /// Adds the light from a direction that the BRDF sampled: distant light, and that of the nearest emitter.
    void add_direction(const Vec3f& direction) {
        if (!(brdf_.normal.dot(direction) > 0)) return;
        if (counts_.environment > 0)
            batch_.add(from_, direction, far_away, {direction, Rgb(0.0f), 0, false, true});
        if (counts_.emitters > 0)
            if (const std::optional<LightSample> light = rays_.emitters.look_up(from_, direction))
                add_emitter(*light);
    }

    double brdf_density(const Vec3f& direction) const {
        double sum = 0;
        if (counts_.cosine > 0)
            sum += counts_.cosine * double(std::max(0.0f, brdf_.normal.dot(direction))) / pi;
        for (std::size_t i = 0; i < counts_.lobes.size(); ++i)
            if (counts_.lobes[i] > 0)
                sum += counts_.lobes[i] * double(lobes_.density(brdf_.lobes[i], direction));
        return sum;
    }

    const RayScene& rays_;
    const VertexBrdf& brdf_;
    const Vec3f from_;
    const Counts counts_;
    const LobeSampling lobes_;
    const Axes<Vec3f> normal_axes_;
    ShadowBatch<Light, Add> batch_;
    Components<Vec3d> sum_;
};

std::uint32_t vertex_seed(std::size_t instance, std::uint32_t vertex) {
    return mixed_seed(mixed_seed(0, std::uint32_t(instance)), vertex);
}

const ShadedEntity& entity_of(const ShadedScene& scene, std::size_t instance) {
    return scene.entities[scene.instances[instance].entity];
}

/// Tests whether a surface of another instance faces a point and touches it: rays of a foot's bottom would
/// start below the floor that it stands on. Surfaces with the orientation of the point's own surface do not
/// count.
bool is_covered(const RayScene& rays, std::size_t instance, const ShadingPoint& at) {
    // From as far behind the surface as `from` is in front of it: coincident surfaces are in between.
    const Vec3f& normal = at.brdf.normal;
    const float height = normal.dot(at.from - at.position);
    RTCRay ray = embree_ray(at.from - normal * (2 * height), normal, 2 * height);
    ray.mask = ~instance_mask(instance);
    const std::optional<RTCRayHit> hit = nearest_hit(rays.surfaces.scene(), ray);
    if (!hit) return false;
    const Placement& other = rays.scene.instances[hit->hit.instID[0]].placement;
    return outwards(*hit).dot(other.direction_to_object(normal)) < 0;
}

/// Computes direct light.
///
/// samples  (const Counts&) -> samples, or a reference to them.
template <class Samples>
Outgoing direct_radiance(const RayScene& rays, const Material& material, const ShadingPoint& at,
                         std::uint32_t count, const Samples& samples) {
    const Counts counts = counts_of(rays, at.brdf, count);
    return Outgoing(PointIntegral(rays, at.brdf, at.from, counts)(samples(counts)) +
                    radiance_from_lamps(rays.lamps, rays.rays, material, at));
}

/// Returns a number that tells which terms of a BRDF are sampled.
std::size_t techniques(const Counts& counts) {
    std::size_t result = counts.cosine > 0;
    for (std::size_t i = 0; i < most_lobes; ++i) result |= std::size_t(counts.lobes[i] > 0) << (i + 1);
    return result;
}

}  // namespace

Outgoing ray_radiance(const RayScene& rays, std::size_t instance, const SurfacePoint& point,
                      std::uint32_t samples, std::uint32_t seed) {
    const ShadingPoint at = shading_point(rays.scene, rays.scene.instances[instance], point);
    if (is_covered(rays, instance, at)) return {};
    return direct_radiance(rays, entity_of(rays.scene, instance).materials[point.material], at, samples,
                           [&](const Counts& counts) { return direct_samples(rays, counts, seed); });
}

RayEstimate ray_estimate(const RayScene& rays, std::size_t instance, std::uint32_t vertex,
                         std::uint32_t samples, std::uint32_t estimates) {
    assert(estimates >= 2);
    const SurfacePoint point = surface_point(entity_of(rays.scene, instance), vertex);
    Vec3d sum(0.0), squares(0.0);
    for (std::uint32_t i = 0; i < estimates; ++i) {
        const Vec3d found(ray_radiance(rays, instance, point, std::max(1u, samples / estimates),
                                       mixed_seed(vertex_seed(instance, vertex), i))
                              .total());
        sum += found;
        squares += found * found;
    }
    RayEstimate result;
    for (int c = 0; c < 3; ++c) {
        const double mean = sum[c] / estimates,
                     variance = std::max(0.0, squares[c] / estimates - mean * mean);
        result.radiance[c] = float(mean);
        result.deviation[c] = float(std::sqrt(variance / (estimates - 1)));
    }
    return result;
}

/// Sets of samples, by techniques(), if a material has these.
struct DirectRays::Sets {
    std::array<std::vector<DirectSamples>, 2u << most_lobes> by_techniques;
};

std::uint32_t DirectRays::set_count(std::uint32_t samples) {
    constexpr std::uint32_t most_sets = 64, most_samples = 1u << 18;
    return std::clamp(most_samples / samples, 1u, most_sets);
}

DirectRays::DirectRays(const RayScene& rays, std::uint32_t samples, std::uint32_t sets)
    : rays_(rays), samples_(samples), count_(sets) {
    auto made = std::make_unique<Sets>();
    for (const ShadedEntity& entity : rays.scene.entities)
        for (const Material& material : entity.materials) {
            const Counts counts = counts_of(rays, surface_brdf<float>(material), samples);
            std::vector<DirectSamples>& found = made->by_techniques[techniques(counts)];
            if (!found.empty()) continue;
            found.resize(sets);
            tbb::parallel_for(std::uint32_t(0), sets,
                              [&](std::uint32_t set) { found[set] = direct_samples(rays, counts, set); });
        }
    sets_ = std::move(made);
}

DirectRays::~DirectRays() = default;

Outgoing DirectRays::radiance(std::size_t instance, const ShadingPoint& at, const Material& material,
                              std::uint32_t number) const {
    if (is_covered(rays_, instance, at)) return {};
    return direct_radiance(rays_, material, at, samples_, [&](const Counts& counts) -> const DirectSamples& {
        return sets_->by_techniques[techniques(counts)][number % count_];
    });
}

/// Traces the paths of vertices.
class RayShader::Paths {
public:
    Paths(const RayScene& rays, const RaySettings& settings)
        : surface_(rays.scene), tracer_(rays, surface_), bounces_(settings.bounces) {
        const std::uint32_t paths = std::max(1u, settings.samples / path_share);
        const std::uint32_t count = DirectRays::set_count(settings.samples);
        for (std::uint32_t set = 0; set < count; ++set)
            sets_.emplace_back(rays.environment, paths, mixed_seed(set, 0x70617468), stored_reflections);
    }

    Outgoing operator()(const ShadingPoint& at, std::uint32_t seed) const {
        return tracer_.indirect_radiance(at.from, at.brdf, sets_[seed % sets_.size()], bounces_);
    }

private:
    static constexpr std::uint32_t path_share = 4, stored_reflections = 3;

    FineSurface surface_;
    PathTracer tracer_;
    std::vector<PathSamples> sets_;
    int bounces_;
};

RayShader::RayShader(const ShadedScene& scene, const RaySettings& settings)
    : rays_(scene), direct_(rays_, settings.samples, DirectRays::set_count(settings.samples)) {
    if (settings.bounces > 0) paths_ = std::make_unique<const Paths>(rays_, settings);
}

RayShader::~RayShader() = default;

Outgoing RayShader::radiance(std::size_t instance, std::uint32_t vertex) const {
    const ShadedEntity& entity = entity_of(rays_.scene, instance);
    const ShadingPoint at = shading_point(rays_.scene, rays_.scene.instances[instance], vertex);
    const std::uint32_t seed = vertex_seed(instance, vertex);
    Outgoing radiance =
        direct_.radiance(instance, at, entity.materials[entity.mesh->vertex_materials[vertex]], seed);
    if (paths_ && !is_covered(rays_, instance, at)) radiance += (*paths_)(at, seed);
    return radiance;
}

Outgoing RayShader::indirect_radiance(std::size_t instance, std::uint32_t vertex,
                                      const Material& material) const {
    ShadingPoint at = shading_point(rays_.scene, rays_.scene.instances[instance], vertex);
    if (!paths_ || is_covered(rays_, instance, at)) return {};
    at.brdf = surface_brdf<float>(material, at.brdf.normal, at.brdf.mirror);
    return (*paths_)(at, vertex_seed(instance, vertex));
}

Result<SceneRadiance> ray_scene_radiance(const ShadedScene& scene, const RaySettings& settings,
                                         const Progress& progress, const PointSharing* sharing) {
    const RayShader shader(scene, settings);
    return evaluated_vertices(
        scene,
        [&]() -> VertexEvaluation {
            return
                [&](std::size_t instance, std::uint32_t vertex) { return shader.radiance(instance, vertex); };
        },
        progress, sharing);
}

Result<SceneRadiance> ray_indirect_radiance(const ShadedScene& scene, std::span<const ShadedEntity> painted,
                                            const RaySettings& settings, const Progress& progress,
                                            const PointSharing* sharing) {
    const RayShader shader(scene, settings);
    return evaluated_vertices(
        scene,
        [&]() -> VertexEvaluation {
            return [&](std::size_t instance, std::uint32_t vertex) {
                const ShadedEntity& entity = painted[scene.instances[instance].entity];
                return shader.indirect_radiance(instance, vertex,
                                                entity.materials[entity.mesh->vertex_materials[vertex]]);
            };
        },
        progress, sharing);
}

}  // namespace haarfield
