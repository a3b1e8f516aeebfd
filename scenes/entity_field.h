#pragma once
/// Selects the samples of an entity's visibility field.

#include "scenes/scene_entities.h"

namespace haarfield {

/// Returns the settings of an entity's field: resolution and compression from the options, sample counts from
/// the description. An entity that is always rasterized exactly gets no samples in space.
FieldSettings entity_field_settings(const Entity& description, const EntityOcclusion& occlusion,
                                    const SceneEntityOptions& options);

}  // namespace haarfield
