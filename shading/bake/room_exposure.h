#pragma once
/// The exposure of an environment that is visible only through the openings of a room.

#include "shading/scene/shaded_scene.h"

#include <span>

namespace haarfield {

/// The stops by which a camera in a room needs more of the environment than automatic_exposure gives: as much
/// as lets white paint (albedo 0.8) not exceed 1 in luminance at nine tenths of the visible points. Lamps and
/// emitters count with their light there, but leave the environment at least a sixteenth. Returns 0 if the
/// eye is outdoors, which is where at least a quarter of all directions is open, and where no light of the
/// environment arrives.
///
/// scene       `eye` is the camera's position; the environment is exposed.
/// directions  of the picture's pixels, or of a few of them.
/// returns     0 to 20.
/// accuracy    some 0.1 stops: surfaces reflect one half, three times, but not the light of lamps and
///             emitters. The same for meshes of any subdivision, and for any number of threads.
/// cost        2,048 paths for each direction if the eye is in a room; 1,024 rays otherwise.
float room_exposure(const ShadedScene& scene, std::span<const Vec3f> directions);

}  // namespace haarfield
