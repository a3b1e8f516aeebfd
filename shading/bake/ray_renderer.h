#pragma once
/// Direct and indirect light by rays: Monte Carlo integration that uses neither the visibility fields of
/// renderer.h nor its splitting of light into sources.

#include "shading/bake/ray_scene.h"
#include "shading/bake/renderer.h"

namespace haarfield {

/// Computes the radiance of a point by direct light.
///
/// Directions are sampled by the environment, by the emitters and by the BRDF's cosine and lobes, and
/// combined by the balance heuristic. Each technique has its own Owen-scrambled Sobol points. Every
/// position of a lamp has one ray. A point that another instance touches (a foot on a floor) is black.
///
/// samples   total number for all techniques; each gets at least one.
/// seed      different seeds are independent estimates.
/// accuracy  unbiased; the error falls faster than 1 / sqrt(samples).
/// cost      about 0.3 us per sample.
/// source    Veach 1997, multiple importance sampling.
Outgoing ray_radiance(const RayScene& rays, std::size_t instance, const SurfacePoint& point,
                      std::uint32_t samples, std::uint32_t seed);

/// Computes direct light as ray_radiance does, with sets of samples that all points share. Threads may share
/// it.
///
/// accuracy  unbiased. Different sets are independent estimates; points with the same set have the same
///           samples.
class DirectRays {
public:
    /// Returns the usual number of sets: 64, or as many as have 2^18 samples.
    static std::uint32_t set_count(std::uint32_t samples);

    /// samples  as for ray_radiance.
    /// cost     0.2 us and 40 bytes per sample of each set, for each combination of terms in the BRDFs.
    DirectRays(const RayScene& rays, std::uint32_t samples, std::uint32_t sets);
    ~DirectRays();

    /// Returns the radiance of a point by the set `number` modulo the number of sets. A point that another
    /// instance touches is black.
    ///
    /// material  of the point's entity; that of `at.brdf`.
    /// cost      0.15 us per sample.
    Outgoing radiance(std::size_t instance, const ShadingPoint& at, const Material& material,
                      std::uint32_t number) const;

private:
    struct Sets;
    const RayScene& rays_;
    std::uint32_t samples_, count_;
    std::unique_ptr<const Sets> sets_;
};

/// The mean radiance of a vertex over independent estimates, and its standard error.
struct RayEstimate {
    Rgb radiance{0.0f}, deviation{0.0f};
};

/// Estimates the radiance of a vertex by direct light.
///
/// estimates  at least 2; they divide the samples.
RayEstimate ray_estimate(const RayScene& rays, std::size_t instance, std::uint32_t vertex,
                         std::uint32_t samples, std::uint32_t estimates = 8);

/// The settings of a bake by rays.
struct RaySettings {
    std::uint32_t samples = 1024;  ///< Of direct light, per vertex. A quarter as many paths are traced.
    int bounces = 0;               ///< Of indirect light; 0: direct light only.
};

/// Shades vertices with samples that are computed once. Threads may share it.
///
/// Vertices share DirectRays::set_count() sets of samples. The set of a vertex, and therefore its radiance,
/// depends on the number of the vertex only.
///
/// accuracy  unbiased. A point that another instance touches is black.
/// cost      0.15 us per sample, and PathTracer's per path.
class RayShader {
public:
    /// The scene must outlive it and must not change.
    ///
    /// cost  that of the BVH of all entities, and 20 ms for the samples.
    RayShader(const ShadedScene& scene, const RaySettings& settings);
    ~RayShader();

    /// Returns the radiance of a vertex by direct light and by the light of the bounces.
    Outgoing radiance(std::size_t instance, std::uint32_t vertex) const;

    /// Returns the part that bounces add, for a vertex of another material.
    Outgoing indirect_radiance(std::size_t instance, std::uint32_t vertex, const Material& material) const;

private:
    class Paths;
    RayScene rays_;
    DirectRays direct_;
    std::unique_ptr<const Paths> paths_;  ///< Null without bounces.
};

/// Returns radiance by instance and vertex, like scene_radiance, with the light of the bounces (RayShader).
///
/// sharing  null: this process shades all vertices.
/// errors   interrupted.
Result<SceneRadiance> ray_scene_radiance(const ShadedScene& scene, const RaySettings& settings,
                                         const Progress& progress = {},
                                         const PointSharing* sharing = nullptr);

/// Returns the part of ray_scene_radiance that bounces add.
///
/// painted  the entities with the materials of the vertices that receive light. They do not change the light
///          that reaches the vertices.
Result<SceneRadiance> ray_indirect_radiance(const ShadedScene& scene, std::span<const ShadedEntity> painted,
                                            const RaySettings& settings, const Progress& progress = {},
                                            const PointSharing* sharing = nullptr);

}  // namespace haarfield
