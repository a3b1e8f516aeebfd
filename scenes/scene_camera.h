#pragma once
/// Where a scene's camera stands if its author does not say, and whether it sees anything there.

#include "scenes/scene_entities.h"

#include <string>
#include <vector>

namespace haarfield {

/// The scene's camera. If it is to be found (Scene::finds_camera), it shows the scene whole, from the front
/// right and somewhat above.
///
/// direction  35 degrees from +z towards +x, 25 degrees above the horizon.
/// place      as near as it can be: the vertices of all objects that count lie in the middle nine tenths of
///            the picture's width and height. Two of them reach that border on opposite sides, and across
///            they are as far from one as from the other. The target is amid their depth.
/// counts     every object but the grounds: those that are flatter than a twentieth of their width, and at
///            least as wide and as deep as all that are not flat together. If nothing else is there they
///            count, too.
/// entities   prepared from this scene, with or without fields; only the original meshes matter.
/// cost       one pass over the instances' triangles.
Camera scene_camera(const Scene& scene, const SceneEntities& entities);

/// Warnings about the scene's camera, one sentence each: the instances that it is inside of (of what is
/// closed: InsideTest), those in front of it that are smaller than a pixel, and that no triangle of any
/// instance is in its picture.
///
/// scene  its camera's place is known: scene_camera.
/// cost   one pass over the instances' triangles.
std::vector<std::string> camera_troubles(const Scene& scene, const SceneEntities& entities);

}  // namespace haarfield
