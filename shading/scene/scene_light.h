#pragma once
/// A scene's light as shading takes it: wavelets of what is smooth, directions of what is concentrated,
/// places of what is near.

#include <stop_token>

#include "shading/scene/shaded_scene.h"
#include "shading/walk/light_pyramid.h"

namespace haarfield {

/// A scene's light, split and laid out for shading.
struct SceneLight {
    LightPyramid smooth;
    std::vector<LightSource> sources;      ///< light_sources.h.
    std::vector<DirectionalLight> lights;  ///< Of all of them.
    std::vector<PlacedLamp> lamps{};
    EmitterTree emitters{};  ///< Of all instances.
};

/// Of faces of RenderSettings::face_size texels, with its rule and its number of wavelets.
///
/// cost  that of split_light and lighting_tree.
/// stop  when it is requested, returns soon, and the light is of no use.
SceneLight scene_light(const Environment& environment, const RenderSettings& settings,
                       const std::stop_token& stop = {});

/// What glows in a scene, in the world.
EmitterTree scene_emitters(const ShadedScene& scene);

/// The same with the scene's lamps and emitters.
SceneLight scene_light(const ShadedScene& scene, const Environment& environment,
                       const RenderSettings& settings, const std::stop_token& stop = {});

/// All of a scene's light.
SceneLight scene_light(const ShadedScene& scene, const RenderSettings& settings,
                       const std::stop_token& stop = {});

}  // namespace haarfield
