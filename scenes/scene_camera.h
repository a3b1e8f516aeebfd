#pragma once
/// Automatic placement of a scene's camera, and warnings about what the camera shows.

#include "scenes/scene_entities.h"

#include <string>
#include <vector>

namespace haarfield {

/// Returns the scene's camera. If Scene::finds_camera is set, places the camera so that it shows all counted
/// objects, from the front right and above.
///
/// direction  35 degrees from +z towards +x, 25 degrees above the horizon.
/// place      the nearest one where the vertices of all counted objects lie within the middle 90 % of the
///            picture's width and height. In one axis, vertices touch both borders; in the other, the objects
///            are centred. The target lies in the middle of their depth.
/// counts     every object except grounds: objects that are flatter than a twentieth of their width, and at
///            least as wide and deep as the box around all objects that are not flat. If all objects are
///            grounds, all count.
/// entities   prepared from this scene, with or without fields; only the original meshes are used.
/// cost       one pass over the instances' triangles.
Camera scene_camera(const Scene& scene, const SceneEntities& entities);

/// Returns warnings about the scene's camera, one sentence each: closed instances that contain it
/// (InsideTest), instances in front of it that are smaller than a pixel, and a picture that shows no
/// triangle.
///
/// scene  its camera's place is known: scene_camera.
/// cost   one pass over the instances' triangles.
std::vector<std::string> camera_troubles(const Scene& scene, const SceneEntities& entities);

}  // namespace haarfield
