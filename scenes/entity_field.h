#pragma once
/// Which field an entity of a scene has.

#include "scenes/scene_entities.h"

namespace haarfield {

/// How the field of an entity is sampled.
FieldSettings entity_field_settings(const Entity& description, const EntityOcclusion& occlusion,
                                    const SceneEntityOptions& options);

}  // namespace haarfield
