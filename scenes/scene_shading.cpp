#include "scenes/scene_shading.h"

#include "scenes/scene_camera.h"

#include <algorithm>

namespace haarfield {

ShadedScene shaded_scene(const Scene& scene, const SceneEntities& entities, Environment environment) {
    ShadedScene shaded;
    for (const auto& entity : entities.entities) {
        shaded.entities.push_back(
            {&entity->mesh.fine, &*entity->occlusion, &entity->field, entity->materials, entity->tints});
        if (std::ranges::any_of(entity->surfaces, &Surface::emits))
            shaded.entities.back().emitters = emitters_of(visible_surface(entity->mesh), entity->surfaces);
    }
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        shaded.instances.push_back({entities.entity_of_instance[i], scene.instances[i].placement});
    shaded.environment = std::move(environment);
    shaded.eye = scene_camera(scene, entities).position;
    shaded.lamps = lamps_of(scene.lamps);
    shaded.filters = entities.filters;
    return shaded;
}

void apply_bounces(const Scene& scene, BounceSettings& bounces) {
    if (bounces.most == any_bounces && scene.bounces) bounces.most = *scene.bounces;
}

}  // namespace haarfield
