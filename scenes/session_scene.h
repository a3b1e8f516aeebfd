#pragma once
/// From a scene's description to a session that relights and edits it.

#include "scenes/scene_entities.h"
#include "shading/transfer/relight_session.h"

namespace haarfield {

/// What a session is opened with. `entities` must have fields, and outlive the session.
SessionScene session_scene(const Scene& scene, const SceneEntities& entities, Environment environment);

}  // namespace haarfield
