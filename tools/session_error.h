#pragma once
/// The error of what a relighting session displays.

#include "bridge/pictures/preview.h"
#include "scenes/scene_entities.h"
#include "shading/transfer/relight_session.h"

namespace haarfield {

/// Measures the error of a session's radiance over the pixels of a picture; see RelightSession::error.
///
/// entities  those of the session's scene.
/// errors    interrupted.
Result<BakeError> session_error(RelightSession& session, const SceneEntities& entities, const Camera& camera,
                                Preview& preview, const Progress& progress = {});

}  // namespace haarfield
