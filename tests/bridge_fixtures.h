#pragma once
/// Small scenes, for the tests of the bridge.

#include "bridge/povray_scene.h"
#include "tests/test_folder.h"

#include <gtest/gtest.h>

#include "tests/example_meshes.h"

namespace haarfield {

inline LatLongImage constant_environment(int height, const Rgb& radiance) {
    LatLongImage image{2 * height, height, {}};
    image.pixels.assign(static_cast<std::size_t>(2 * height * height), radiance);
    return image;
}

/// A camera at (0, 0, distance) that looks at the origin: a square of half edge 1 fills the picture.
inline Camera frontal_camera(float distance, int size) {
    Camera camera;
    camera.position = Vec3f(0, 0, distance);
    camera.target = Vec3f(0, 0, 0);
    camera.vertical_fov = 2 * std::atan(1 / distance);
    camera.width = camera.height = size;
    return camera;
}

}  // namespace haarfield
