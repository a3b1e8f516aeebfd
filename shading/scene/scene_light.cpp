#include "shading/scene/scene_light.h"

#include "shading/scene/lighting.h"

namespace haarfield {
namespace {

/// A cluster is about as wide as what one direction represents by default, and has few lights. [rad]
constexpr float cluster_angle = 0.007f;
constexpr std::size_t cluster_lights = 16;

}  // namespace

SceneLight scene_light(const Environment& environment, const RenderSettings& settings,
                       const std::stop_token& stop) {
    SplitLight split = split_light(environment, settings.sources);
    std::vector<DirectionalLight> lights = all_lights(split.sources);
    std::vector<LightCluster> clusters;
    if (settings.sources.direction_factor > 1)
        clusters = light_clusters(lights, cluster_angle, cluster_lights);
    return {LightPyramid(lighting_tree(split.smooth, settings.face_size, {settings.light_coefficients}, stop),
                         settings.face_size),
            std::move(split.sources), std::move(lights), std::move(clusters)};
}

EmitterTree scene_emitters(const ShadedScene& scene) {
    std::vector<Emitter> emitters;
    for (const ShadedInstance& instance : scene.instances)
        for (Emitter emitter : scene.entities[instance.entity].emitters) {
            for (Vec3f& corner : emitter.corners) corner = instance.placement.point_to_world(corner);
            emitters.push_back(emitter);
        }
    return emitter_tree(std::move(emitters));
}

SceneLight scene_light(const ShadedScene& scene, const Environment& environment,
                       const RenderSettings& settings, const std::stop_token& stop) {
    SceneLight light = scene_light(environment, settings, stop);
    light.lamps = placed_lamps(scene.lamps);
    light.emitters = scene_emitters(scene);
    return light;
}

SceneLight scene_light(const ShadedScene& scene, const RenderSettings& settings,
                       const std::stop_token& stop) {
    return scene_light(scene, scene.environment, settings, stop);
}

}  // namespace haarfield
