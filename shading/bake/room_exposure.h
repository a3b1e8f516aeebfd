#pragma once
/// The exposure of an environment that is visible only through the openings of a room.

#include "shading/scene/shaded_scene.h"

#include <span>

namespace haarfield {

/// Returns the stops to add to automatic_exposure for a camera in a room. [stops]
///
/// No channel of white paint (albedo 0.8) then exceeds 1 at nine tenths of the visible points. The light of
/// lamps and emitters at a point counts, but leaves the environment at least a sixteenth of the radiance.
/// The result is 0 if no light of the environment arrives, or if the eye is outdoors: at least a quarter of
/// all directions are unoccluded.
///
/// scene       `eye` is the camera's position; the environment is exposed.
/// directions  of all or a few pixels of the picture.
/// returns     0 to 20.
/// accuracy    about 0.1 stops. All surfaces of an entity have its mean albedo. Light of lamps and emitters
///             is not reflected. The result does not depend on the number of threads, and on the
///             subdivision of meshes only by that mean.
/// cost        2,048 paths for each direction if the eye is in a room; 1,024 rays otherwise.
float room_exposure(const ShadedScene& scene, std::span<const Vec3f> directions);

}  // namespace haarfield
