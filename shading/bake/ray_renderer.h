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
/// Vertices share 64 sets of samples, or as many as have 2^18 samples. The set of a vertex, and therefore its
/// radiance, depends on the number of the vertex only.
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
    struct Samples;
    RayScene rays_;
    RaySettings settings_;
    std::unique_ptr<const Samples> samples_;
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
