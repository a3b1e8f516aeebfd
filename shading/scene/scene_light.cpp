#include "shading/scene/scene_light.h"

#include "shading/scene/lighting.h"

namespace haarfield {

SceneLight scene_light(const Environment& environment, const RenderSettings& settings,
                       const std::stop_token& stop) {
    SplitLight split = split_light(environment, settings.sources);
    std::vector<DirectionalLight> lights = all_lights(split.sources);
    return {LightPyramid(lighting_tree(split.smooth, settings.face_size, {settings.light_coefficients}, stop),
                         settings.face_size),
            std::move(split.sources), std::move(lights)};
}

}  // namespace haarfield
