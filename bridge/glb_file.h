#pragma once
/// The shaded scene as glTF, for Blender, viewers and engines.

#include "bridge/baked_scene.h"

namespace haarfield {

/// Writes all instances as one binary glTF 2.0 file; atomically.
///
/// Each instance is a node of its name, with its placement as `matrix`, and a mesh: POSITION, NORMAL (float,
/// in the object's frame), COLOR_0 (three floats: linear radiance, unclamped), the same once more by the name
/// of _RADIANCE, each pass as _NAME (_OWN_SHADOW; a float, or three), and indices. Instances of one mesh
/// share all but these. The one material is white and unlit (KHR_materials_unlit): what is seen is the
/// colour, with that of images at the vertices. Nothing is turned: the frame of glTF is ours.
/// Programs that keep colours in eight bits (Blender 3.4 does) clip COLOR_0 to [0, 1]; newer ones give custom
/// attributes such as _RADIANCE as they are.
///
/// instances  at least one; glTF knows no empty lists.
/// errors     as write_baked_scene; none at all; more than 4 GiB.
/// cost       36 bytes a vertex, 12 or 4 more a pass, 12 a triangle; as much memory again.
Result<Done> write_baked_glb(const std::filesystem::path& file, std::span<const BakedInstance> instances);

}  // namespace haarfield
