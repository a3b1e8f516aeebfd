#pragma once
/// The occluders and the light of a scene for Monte Carlo integration.

#include <span>

#include "shading/bake/environment_sampler.h"
#include "shading/visibility/shadow_rays.h"

namespace haarfield {

/// The occluders and the light of rays and paths.
struct RayScene {
    /// The scene must outlive it and must not change.
    ///
    /// cost  that of two BVHs of each entity.
    explicit RayScene(const ShadedScene& scene);

    /// Directs samples of the environment to where its light reaches these points and what they see: in a
    /// room with a window, most other samples are blocked. Nothing changes where a tenth of the light or more
    /// arrives. To be called before anything uses the environment.
    ///
    /// of_interest  some hundred points.
    /// cost         3 ms of processor time for 512 points; 70 ms in rooms.
    void focus(std::span<const SurfacePlace> of_interest);

    const ShadedScene& scene;
    ShadowRays rays;              ///< The original meshes, without alpha cutouts.
    InstancedTriangles surfaces;  ///< The same meshes, for rays that need the normal of what they hit.
    EnvironmentSampler environment;
    EmitterSampler emitters;
    std::vector<PlacedLamp> lamps;
};

}  // namespace haarfield
