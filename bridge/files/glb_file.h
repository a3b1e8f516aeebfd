#pragma once
/// Writes the shaded scene as glTF, for Blender, viewers and engines.

#include "bridge/povray/baked_scene.h"

namespace haarfield {

/// Writes all instances as one binary glTF 2.0 file, atomically.
///
/// Each instance is a node with the instance's name, its placement as `matrix`, and a mesh. The vertex
/// attributes are POSITION and NORMAL (float, in the object's frame), COLOR_0 (three floats: linear radiance,
/// unclamped), a copy of the radiance as _RADIANCE, and each pass as _NAME (such as _OWN_SHADOW; one float or
/// three). Instances of one mesh share indices, POSITION, NORMAL and TEXCOORD_0.
///
/// Materials are unlit (KHR_materials_unlit). One material is white and displays COLOR_0. Each image has a
/// further material with TEXCOORD_0, which displays the image times COLOR_0. COLOR_0 then contains the light
/// that the image multiplies, with the vertex colours applied. It also contains the specular radiance,
/// divided by the image's mean around the vertex (at least 0.04). _RADIANCE is the displayed radiance at the
/// vertices, including the image.
///
/// Images are embedded: the bytes of the original PNG or JPEG file, or a PNG of the texels if the alpha was
/// changed or the file had another format. alphaMode is MASK if alpha is 0 or 1 everywhere, otherwise BLEND.
/// Nothing is rotated, because haarfield's frame is that of glTF. Programs that store colours in eight bits,
/// such as Blender 3.4, clip COLOR_0 to [0, 1]. Newer programs provide custom attributes such as _RADIANCE
/// unchanged.
///
/// instances  at least one, because glTF forbids empty lists.
/// errors     as write_baked_scene; no instance; more than 4 GiB.
/// cost       36 bytes per vertex, 20 more with images, 12 or 4 more per pass, 12 per triangle; the images.
///            The memory use is twice the file size.
Result<Done> write_baked_glb(const std::filesystem::path& file, std::span<const BakedInstance> instances);

}  // namespace haarfield
