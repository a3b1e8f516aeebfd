#pragma once
/// A bake at the vertices that the models' files list, for round trips.

#include "scenes/baked_instance.h"
#include "scenes/scene_entities.h"

namespace haarfield {

/// Instances whose vertices and faces are those of their files: all of them, in the file's order.
struct OriginalBake {
    std::vector<Mesh> meshes;              ///< By SceneEntities::entities.
    std::vector<Mesh> textured_meshes;     ///< Likewise; without triangles where there is no texture.
    std::vector<std::vector<Rgb>> values;  ///< Of the instances, which refer to them, as to the meshes.
    std::vector<BakedInstance> instances;  ///< In the bake's order.
    /// The same instances for file formats with images. If an entity has textures, its mesh has texture
    /// coordinates, and its values are light without the images. The vertices of the file come first. A
    /// vertex at a seam of the texture coordinates or between materials is repeated after them.
    std::vector<BakedInstance> textured;
    std::size_t vertices = 0, unvalued = 0;  ///< Of all instances; those of which no light is known.
};

/// What a bake gives to the vertices of the files.
///
/// A vertex at which normals or images' coordinates part, so that it was baked more than once, has the mean,
/// weighted by the angles of its faces; of a sheet that is baked from both sides it has the front. Radiance
/// is what is seen, with the colour of an image there. One that no baked triangle uses (only degenerate faces
/// do, or duplicate ones, or none at all) has what lies at its place, of the side that its own faces have
/// there; if nothing does its radiance and passes are 0. Normals are found likewise, (0, 1, 0) where there is
/// nothing. Vertices that are not finite stand at the origin.
///
/// entities     prepared with SceneEntityOptions::original_vertices (asserted).
/// instances    of a bake of their fine meshes. Both must outlive the result.
/// with_images  false: `textured` and `textured_meshes` stay empty.
OriginalBake original_bake(const SceneEntities& entities, std::span<const BakedInstance> instances,
                           bool with_images);

}  // namespace haarfield
