#include "shading/bake/ray_scene.h"

#include "shading/scene/scene_light.h"

namespace haarfield {

RayScene::RayScene(const ShadedScene& of)
    : scene(of),
      environment(of.environment),
      emitters(scene_emitters(of).triangles),
      lamps(placed_lamps(of.lamps)) {
    rays.build(of);
    for (const ShadedEntity& entity : of.entities)
        surfaces.add_entity(entity.occlusion->original().positions(),
                            entity.occlusion->original().triangles());
    surfaces.place(of);
}

}  // namespace haarfield
