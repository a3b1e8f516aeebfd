#include "scenes/session_scene.h"

namespace haarfield {

SessionScene session_scene(const Scene& scene, const SceneEntities& entities, Environment environment) {
    SessionScene session;
    session.entities.resize(scene.entities.size());
    for (const auto& entity : entities.entities) {
        session.entities[entity->entity] = {scene.entities[entity->entity].name,
                                            entities.unturned.at(entity->entity).get(),
                                            entity->field.settings, entity->materials};
        session.poses.push_back(
            {entity->entity, entity->rotate, &entity->mesh.fine, &*entity->occlusion, &entity->field});
    }
    for (const Instance& instance : scene.instances)
        session.instances.push_back({instance.entity, instance.placement, instance.rotate});
    session.environment = std::move(environment);
    session.eye = scene.camera.position;
    return session;
}

}  // namespace haarfield
