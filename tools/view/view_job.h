#pragma once
/// The jobs of a session, and the messages that interrupt them.

#include "tools/view/live_scene.h"
#include "tools/view/messages.h"

namespace haarfield {

struct ViewJob {
    enum class For {
        nothing,
        frame,     ///< With existing vectors, or with another exposure.
        vectors,   ///< Computes vectors, then a frame.
        shade,     ///< Shades in full; occlusion by other objects from their fields.
        recommit,  ///< Exact, if that is as fast because nothing has moved.
        commit,    ///< Exact, when edits pause.
        likely,    ///< Computes vectors for the likely next edit.
        measure,   ///< Measures the error of exact colours.
    };
    For what = For::nothing;
    Variation variation;  ///< Of frames and vectors.
};

/// True if a message ends a running job. Jobs for the same gesture and instantaneous jobs continue.
///
/// eye  the position in the last message; none if the colours do not depend on the eye.
bool job_ends_for(const ViewJob& job, const Content& message, const std::optional<Vec3f>& eye);

/// True if a place equals that of a camera's eye or target, except for rounding in the page.
bool is_same_place(const Vec3f& one, const Vec3f& other, const Camera& camera);

}  // namespace haarfield
