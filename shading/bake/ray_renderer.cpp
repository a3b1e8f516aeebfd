#include "shading/bake/ray_renderer.h"

#include <cassert>

#include "fields/base/embree_rays.h"
#include "shading/bake/lamp_light.h"
#include "shading/bake/scrambled_sobol.h"
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

/// Sums the contributions of unoccluded rays, in packets of sixteen.
class RayBatch {
public:
    RayBatch(const ShadowRays& rays, const Vec3f& from) : rays_(rays) { from_.fill(from); }

    void add(const LightSample& light, const Components<Vec3d>& contribution) {
        constexpr float horizon = 1e6f;  // larger than any scene [m]
        ends_[size_] = from_[0] + light.direction * std::min(light.distance, horizon);
        contributions_[size_] = contribution;
        if (++size_ == ShadowRays::packet) trace();
    }
    Components<Vec3d> sum() {
        trace();
        return sum_;
    }

private:
    void trace() {
        const auto wanted = std::uint16_t((1u << size_) - 1);
        const std::uint16_t blocked =
            rays_.blocked_from(std::span(from_).first(size_), wanted, std::span(ends_).first(size_));
        for (std::size_t i = 0; i < size_; ++i)
            if (!(blocked >> i & 1u)) sum_ += contributions_[i];
        size_ = 0;
    }

    const ShadowRays& rays_;
    std::array<Vec3f, ShadowRays::packet> from_, ends_;
    std::array<Components<Vec3d>, ShadowRays::packet> contributions_;
    std::size_t size_ = 0;
    Components<Vec3d> sum_;
};

/// Estimates the integral over the directions above one point.
class PointIntegral {
public:
    PointIntegral(const RayScene& rays, const VertexBrdf& brdf, const Vec3f& from, std::uint32_t samples)
        : rays_(rays),
          brdf_(brdf),
          from_(from),
          counts_(counts_of(rays, brdf, samples)),
          lobes_(brdf),
          normal_axes_(axes_across(brdf.normal)),
          batch_(rays.rays, from) {}

    Components<Vec3d> operator()(std::uint32_t seed) {
        if (counts_.environment == 0 && counts_.emitters == 0) return {};
        for_each(seed, by_environment, counts_.environment, [this](const std::array<double, 2>& place) {
            const LightSample light = rays_.environment.sample(place);
            add(light, light.is_disc ? counts_.environment * light.density
                                     : counts_.environment * light.density + brdf_density(light.direction));
        });
        for_each(seed, by_emitters, counts_.emitters, [this](const std::array<double, 2>& place) {
            if (const std::optional<LightSample> light = rays_.emitters.sample(from_, place))
                add(*light, counts_.emitters * light->density + brdf_density(light->direction));
        });
        for_each(seed, by_cosine, counts_.cosine, [this](const std::array<double, 2>& place) {
            add_direction(
                cosine_direction(Vec2f(float(place[0]), float(place[1])), brdf_.normal, normal_axes_));
        });
        for (std::uint32_t i = 0; i < counts_.lobes.size(); ++i)
            for_each(seed, by_lobes + i, counts_.lobes[i], [&](const std::array<double, 2>& place) {
                const Vec2f at{float(place[0]), float(place[1])};
                add_direction(lobes_.direction(brdf_.lobes[i], at).normalized());
            });
        return batch_.sum();
    }

private:
    template <class Use>
    static void for_each(std::uint32_t seed, std::uint32_t technique, std::uint32_t count, const Use& use) {
        const ScrambledSobol points(mixed_seed(seed, technique));
        for (std::uint32_t i = 0; i < count; ++i) use(points(i));
    }

    /// Adds a sample by the balance heuristic.
    ///
    /// densities  sum over the techniques that sample the direction: density times number of samples.
    void add(const LightSample& light, double densities) {
        if (!(densities > 0)) return;
        const auto contribution =
            Components<Vec3d>(reflectance(brdf_, light.direction) * light.radiance) * (1 / densities);
        if (contribution != Components<Vec3d>()) batch_.add(light, contribution);
    }

    /// Adds the light from a direction that the BRDF sampled: distant light, and that of the nearest emitter.
    void add_direction(const Vec3f& direction) {
        if (!(brdf_.normal.dot(direction) > 0)) return;
        const double by_brdf = brdf_density(direction);
        if (counts_.environment > 0) {
            LightSample light{direction, Rgb(0.0f), 0, far_away, false};
            rays_.environment.look_up(direction, light.radiance, light.density);
            add(light, counts_.environment * light.density + by_brdf);
        }
        if (counts_.emitters > 0)
            if (const std::optional<LightSample> light = rays_.emitters.look_up(from_, direction))
                add(*light, counts_.emitters * light->density + by_brdf);
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
    RayBatch batch_;
};

std::uint32_t vertex_seed(std::size_t instance, std::uint32_t vertex) {
    return mixed_seed(mixed_seed(0, std::uint32_t(instance)), vertex);
}

const ShadedEntity& entity_of(const ShadedScene& scene, std::size_t instance) {
    return scene.entities[scene.instances[instance].entity];
}

/// Tests whether a surface of another instance faces a point and touches it. Surfaces with the orientation of
/// the point's own surface do not count.
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

}  // namespace

RayScene::RayScene(const ShadedScene& of)
    : scene(of),
      environment(of.environment),
      emitters(scene_emitters(of).triangles),
      lamps(placed_lamps(of.lamps)) {
    rays.build(of);
    for (const ShadedEntity& entity : of.entities)
        surfaces.add_entity(entity.occlusion->original().positions(),
                            entity.occlusion->original().triangles());
    surfaces.place(of);
}

Outgoing ray_radiance(const RayScene& rays, std::size_t instance, const SurfacePoint& point,
                      std::uint32_t samples, std::uint32_t seed) {
    const ShadedInstance& placed = rays.scene.instances[instance];
    const Material& material = entity_of(rays.scene, instance).materials[point.material];
    const ShadingPoint at = shading_point(rays.scene, placed, point);
    // Rays of a foot's bottom would start below the floor that it stands on.
    if (is_covered(rays, instance, at)) return {};
    return Outgoing(PointIntegral(rays, at.brdf, at.from, samples)(seed) +
                    radiance_from_lamps(rays.lamps, rays.rays, material, at));
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

Result<SceneRadiance> ray_scene_radiance(const ShadedScene& scene, std::uint32_t samples,
                                         const Progress& progress, const PointSharing* sharing) {
    const RayScene rays(scene);
    return evaluated_vertices(
        scene,
        [&]() -> VertexEvaluation {
            return [&](std::size_t instance, std::uint32_t vertex) {
                return ray_radiance(rays, instance, surface_point(entity_of(scene, instance), vertex),
                                    samples, vertex_seed(instance, vertex));
            };
        },
        progress, sharing);
}

}  // namespace haarfield
