#pragma once
/// The shaded scene as glTF, for Blender, viewers and engines.

#include "bridge/povray/baked_scene.h"

namespace haarfield {

/// Writes all instances as one binary glTF 2.0 file; atomically.
///
/// Each instance is a node of its name, with its placement as `matrix`, and a mesh: POSITION, NORMAL (float,
/// in the object's frame), COLOR_0 (three floats: linear radiance, unclamped), the same once more by the name
/// of _RADIANCE, each pass as _NAME (_OWN_SHADOW; a float, or three), and indices. Instances of one mesh
/// share all but these. Materials are unlit (KHR_materials_unlit). One is white: what is seen is the colour.
/// For each image that a surface shows there is another, with TEXCOORD_0: what is seen is the image times
/// COLOR_0, which there is the light that the image multiplies, at its vertices with what vertices' colours
/// make of it. Highlights, which lie over an image, are in it too, divided by the image's mean round the
/// vertex (at least 0.04). _RADIANCE is what is seen at the vertices, image and all. Images are in the file:
/// the bytes of a PNG or JPEG that they were read from, or a PNG of their texels, if their alpha was changed
/// or they were something else; alpha is as MASK where it is all or nothing, else as BLEND. Nothing is
/// turned: the frame of glTF is ours. Programs that keep colours in eight bits (Blender 3.4 does) clip
/// COLOR_0 to [0, 1]; newer ones give custom attributes such as _RADIANCE as they are.
///
/// instances  at least one; glTF knows no empty lists.
/// errors     as write_baked_scene; none at all; more than 4 GiB.
/// cost       36 bytes a vertex, 20 more with images, 12 or 4 more a pass, 12 a triangle; the images. As much
///            memory again.
Result<Done> write_baked_glb(const std::filesystem::path& file, std::span<const BakedInstance> instances);

}  // namespace haarfield
