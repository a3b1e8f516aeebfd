#include "scenes/camera_frame.h"

#include <cassert>

namespace haarfield {

CameraFrame camera_frame(const Camera& camera) {
    const Vec3d to_target = Vec3d(camera.target) - Vec3d(camera.position);
    assert(to_target.length() > 0);
    CameraFrame frame;
    frame.forward = to_target.normalized();
    frame.right = frame.forward.cross(Vec3d(0, 1, 0));
    if (frame.right.length() < 1e-6) frame.right = Vec3d(1, 0, 0);
    frame.right.normalize();
    frame.up = frame.right.cross(frame.forward);
    return frame;
}

}  // namespace haarfield
