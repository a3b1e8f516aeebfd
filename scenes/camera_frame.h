#pragma once
/// The coordinate frame of a camera.

#include "scenes/scene.h"

namespace haarfield {

/// The viewing direction, right and up of a camera: right-handed unit vectors. If the camera points straight
/// up or down, right is +x.
struct CameraFrame {
    Vec3d forward, right, up;
};

/// Computes the frame. The camera's position and target differ (asserted).
CameraFrame camera_frame(const Camera& camera);

}  // namespace haarfield
