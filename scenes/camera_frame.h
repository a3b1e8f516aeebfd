#pragma once
/// How a camera looks into the scene.

#include "scenes/scene.h"

namespace haarfield {

/// Right-handed; right and up are unit vectors, and so is forward. Looking straight up or down, +x is on the
/// right.
struct CameraFrame {
    Vec3d forward, right, up;
};

/// The camera's position and target differ (asserted).
CameraFrame camera_frame(const Camera& camera);

}  // namespace haarfield
