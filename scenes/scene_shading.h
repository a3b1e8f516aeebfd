#pragma once
/// From a scene and its prepared entities to the scene that shading reads.

#include "scenes/scene_entities.h"

namespace haarfield {

/// Combines entities, placements, lights and the position of the camera for scene_radiance. `entities` must
/// outlive the result.
ShadedScene shaded_scene(const Scene& scene, const SceneEntities& entities, Environment environment);

/// Replaces unlimited bounces by those of the scene, if it limits them.
void apply_bounces(const Scene& scene, BounceSettings& bounces);

}  // namespace haarfield
