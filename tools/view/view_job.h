#pragma once
/// What a session computes at a time, and which messages make that useless.

#include "tools/view/live_scene.h"
#include "tools/view/messages.h"

namespace haarfield {

struct ViewJob {
    enum class For {
        nothing,
        frame,     ///< By vectors that are there, or by another exposure.
        vectors,   ///< And a frame.
        shade,     ///< In full, past other objects by their fields.
        recommit,  ///< Exactly, where that is as quick: nothing has moved.
        commit,    ///< Exactly, at rest.
        likely,    ///< Vectors for what may come.
    };
    For what = For::nothing;
    Variation variation;  ///< Of frames and vectors.
};

/// Whether a message that arrives ends a running job. What is for the same gesture, or done at once, goes on.
///
/// eye  where the last message had it; none if the colours do not depend on it.
bool job_ends_for(const ViewJob& job, const Content& message, const std::optional<Vec3f>& eye);

/// Whether a place is that of a camera's eye or target: pages compute it with other roundings.
bool is_same_place(const Vec3f& one, const Vec3f& other, const Camera& camera);

}  // namespace haarfield
