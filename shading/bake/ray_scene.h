#pragma once
/// The occluders and the light of a scene for Monte Carlo integration.

#include "shading/bake/environment_sampler.h"
#include "shading/visibility/shadow_rays.h"

namespace haarfield {

/// The occluders and the light of rays and paths.
struct RayScene {
    /// The scene must outlive it and must not change.
    ///
    /// cost  that of two BVHs of each entity.
    explicit RayScene(const ShadedScene& scene);

    const ShadedScene& scene;
    ShadowRays rays;              ///< The original meshes, without alpha cutouts.
    InstancedTriangles surfaces;  ///< The same meshes, for rays that need the normal of what they hit.
    EnvironmentSampler environment;
    EmitterSampler emitters;
    std::vector<PlacedLamp> lamps;
};

}  // namespace haarfield
