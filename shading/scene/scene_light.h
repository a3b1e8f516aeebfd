#pragma once
/// The light of a scene, prepared for shading: wavelets for smooth light, directions for concentrated light,
/// positions for local light.

#include <stop_token>

#include "shading/scene/light_clusters.h"
#include "shading/scene/shaded_scene.h"
#include "shading/walk/light_pyramid.h"

namespace haarfield {

/// The light of a scene, split and prepared for shading.
struct SceneLight {
    LightPyramid smooth;
    std::vector<LightSource> sources;      ///< light_sources.h.
    std::vector<DirectionalLight> lights;  ///< Of all sources.
    /// Clusters of these lights. Empty: each light needs its own shadow ray.
    std::vector<LightCluster> clusters{};
    std::vector<PlacedLamp> lamps{};
    EmitterTree emitters{};  ///< Of all instances, in the world.
};

/// Prepares an environment for faces of RenderSettings::face_size texels, with the source rule and the number
/// of wavelets of the settings.
///
/// cost  that of split_light and lighting_tree.
/// stop  once requested, returns soon with unspecified light.
SceneLight scene_light(const Environment& environment, const RenderSettings& settings,
                       const std::stop_token& stop = {});

/// Returns the emitters of all instances, in the world.
EmitterTree scene_emitters(const ShadedScene& scene);

/// Prepares an environment with the scene's lamps and emitters.
SceneLight scene_light(const ShadedScene& scene, const Environment& environment,
                       const RenderSettings& settings, const std::stop_token& stop = {});

/// Prepares all light of a scene.
SceneLight scene_light(const ShadedScene& scene, const RenderSettings& settings,
                       const std::stop_token& stop = {});

}  // namespace haarfield
