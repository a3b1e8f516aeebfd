#include "tools/session_error.h"

#include "scenes/bake_search.h"

namespace haarfield {

Result<BakeError> session_error(RelightSession& session, const SceneEntities& entities, const Camera& camera,
                                Preview& preview, const Progress& progress) {
    constexpr double accuracy = 0.01;
    SceneRadiance shown;
    for (std::size_t i = 0; i < session.instances().size(); ++i) shown.push_back(session.outgoing(i));
    const auto pixels = preview.points(camera, preview_instances(entities, session.scene()));
    return session.error(shown, displayed_points(entities, session.scene(), pixels), accuracy, progress);
}

}  // namespace haarfield
