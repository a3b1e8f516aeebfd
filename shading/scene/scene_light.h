#pragma once
/// A scene's light as shading takes it: wavelets of what is smooth, directions of what is concentrated.

#include <stop_token>

#include "shading/scene/shaded_scene.h"
#include "shading/walk/light_pyramid.h"

namespace haarfield {

/// A scene's light, split and laid out for shading.
struct SceneLight {
    LightPyramid smooth;
    std::vector<LightSource> sources;      ///< light_sources.h.
    std::vector<DirectionalLight> lights;  ///< Of all of them.
};

/// Of faces of RenderSettings::face_size texels, with its rule and its number of wavelets.
///
/// cost  that of split_light and lighting_tree.
/// stop  when it is requested, returns soon, and the light is of no use.
SceneLight scene_light(const Environment& environment, const RenderSettings& settings,
                       const std::stop_token& stop = {});

}  // namespace haarfield
