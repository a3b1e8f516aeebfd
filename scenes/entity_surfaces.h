#pragma once
/// The surfaces of an entity's mesh: what its file says, and what the scene puts in its place.

#include "fields/model/mesh_reader.h"
#include "scenes/model_warnings.h"
#include "scenes/scene.h"
#include "scenes/surface.h"

namespace haarfield {

/// Textures that were read, so that each is there once.
class TextureShelf {
public:
    /// errors  as read_texture.
    Result<std::shared_ptr<const Texture>> texture(const TextureSource& source);

private:
    std::vector<std::pair<TextureSource, std::shared_ptr<const Texture>>> textures_;
};

/// Tests whether a material of the mesh is as its file has it.
bool uses_file_materials(const Entity& entity, const ImportedMesh& imported);

/// By the mesh's materials: the scene's material where the entity names one for it or for all, else the
/// file's.
///
/// imported  the entity's mesh, with its appearance.
/// warnings  grow by images that are not there or can not be put on the mesh, and by what haarfield does not
///           use of the file's materials.
/// errors    a name in Entity::materials that the file does not have; a scene's image on a part without
///           texture coordinates; images that can not be read.
Result<std::vector<Surface>> entity_surfaces(const Scene& scene, const Entity& entity,
                                             const ImportedMesh& imported, TextureShelf& shelf,
                                             ModelWarnings& warnings);

/// Returns surfaces with the materials that a scene names for them. Images and vertex colours remain.
///
/// entity    the description of the mesh.
/// names     of the mesh's materials.
/// prepared  the surfaces of the mesh as it was prepared: where the scene names no material, they remain.
std::vector<Surface> with_scene_materials(const Scene& scene, const Entity& entity,
                                          std::span<const std::string> names, std::vector<Surface> prepared);

}  // namespace haarfield
