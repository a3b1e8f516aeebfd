#pragma once
/// Writes a bake at the vertices that the model files list, for round trips.

#include "scenes/baked_instance.h"
#include "scenes/scene_entities.h"

namespace haarfield {

/// Instances with the vertices and faces of their model files: all of them, in the file's order. assimp 5.4
/// lists the vertices of glTF files in the order of their first use, without unused ones.
struct OriginalBake {
    std::vector<Mesh> meshes;              ///< By SceneEntities::entities.
    std::vector<Mesh> textured_meshes;     ///< By entity. Without triangles if the entity has no texture.
    std::vector<std::vector<Rgb>> values;  ///< The values that the instances refer to.
    std::vector<BakedInstance> instances;  ///< In the order of the bake.
    /// The instances for file formats with images. If an entity has textures, its mesh has texture
    /// coordinates, and its values are light without the images. The vertices of the file come first. A
    /// vertex at a seam of the texture coordinates or between materials is repeated after them.
    std::vector<BakedInstance> textured;
    std::size_t vertices = 0, unvalued = 0;  ///< Vertices of all instances, and those without a value.
};

/// Transfers a bake to the vertices of the model files.
///
/// A vertex that was baked several times, because normals or texture coordinates differ between its faces,
/// gets the mean weighted by the angles of its faces. In a sheet that is baked on both sides, it gets the
/// value of the front. Radiance is the displayed radiance, multiplied by the colour of an image there.
///
/// A vertex without a baked triangle has only degenerate or duplicate faces, or none. It gets the value of
/// the baked vertices at its position on the side to which its faces point. Without such vertices, its
/// radiance and passes are 0. Normals follow the same rules, with (0, 1, 0) as the default. Vertices with
/// non-finite coordinates move to the origin.
///
/// entities     prepared with SceneEntityOptions::original_vertices (asserted).
/// instances    a bake of the entities' fine meshes. Entities and instances must outlive the result.
/// with_images  false: `textured` and `textured_meshes` stay empty.
OriginalBake original_bake(const SceneEntities& entities, std::span<const BakedInstance> instances,
                           bool with_images);

}  // namespace haarfield
