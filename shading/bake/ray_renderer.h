#pragma once
/// Direct light by rays: Monte Carlo integration that uses neither the visibility fields of renderer.h nor
/// its splitting of light into sources.

#include "shading/bake/environment_sampler.h"
#include "shading/bake/renderer.h"
#include "shading/visibility/shadow_rays.h"

namespace haarfield {

/// The occluders and the light of rays.
struct RayScene {
    /// The scene must outlive it and must not change.
    explicit RayScene(const ShadedScene& scene);

    const ShadedScene& scene;
    ShadowRays rays;              ///< The original meshes, without alpha cutouts.
    InstancedTriangles surfaces;  ///< The same meshes, for rays that need the normal of what they hit.
    EnvironmentSampler environment;
    EmitterSampler emitters;
    std::vector<PlacedLamp> lamps;
};

/// Computes the radiance of a point by direct light.
///
/// Directions are sampled by the environment, by the emitters and by the BRDF's cosine and lobes, and
/// combined by the balance heuristic. Each technique has its own Owen-scrambled Sobol points. Every
/// position of a lamp has one ray. A point that another instance touches (a foot on a floor) is black.
///
/// samples   total number for all techniques; each gets at least one.
/// seed      different seeds are independent estimates.
/// accuracy  unbiased; the error falls faster than 1 / sqrt(samples).
/// cost      about 0.2 us per sample.
/// source    Veach 1997, multiple importance sampling.
Outgoing ray_radiance(const RayScene& rays, std::size_t instance, const SurfacePoint& point,
                      std::uint32_t samples, std::uint32_t seed);

/// The mean radiance of a vertex over independent estimates, and its standard error.
struct RayEstimate {
    Rgb radiance{0.0f}, deviation{0.0f};
};

/// Estimates the radiance of a vertex.
///
/// estimates  at least 2; they divide the samples.
RayEstimate ray_estimate(const RayScene& rays, std::size_t instance, std::uint32_t vertex,
                         std::uint32_t samples, std::uint32_t estimates = 8);

/// Returns radiance by instance and vertex, like scene_radiance. The samples of a vertex depend only on its
/// number.
///
/// sharing  null: this process shades all vertices.
/// errors   interrupted.
Result<SceneRadiance> ray_scene_radiance(const ShadedScene& scene, std::uint32_t samples,
                                         const Progress& progress = {},
                                         const PointSharing* sharing = nullptr);

}  // namespace haarfield
