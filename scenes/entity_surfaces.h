#pragma once
/// The surfaces of an entity's mesh: materials of the mesh file, or the scene's replacements.

#include "fields/model/mesh_reader.h"
#include "scenes/model_warnings.h"
#include "scenes/scene.h"
#include "scenes/surface.h"

namespace haarfield {

/// A cache of textures: each image is read and stored once.
class TextureShelf {
public:
    /// Returns the texture of a source, reading it on first use.
    ///
    /// errors  as read_texture.
    Result<std::shared_ptr<const Texture>> texture(const TextureSource& source);

private:
    std::vector<std::pair<TextureSource, std::shared_ptr<const Texture>>> textures_;
};

/// Tests whether at least one material of the mesh comes from its file.
bool uses_file_materials(const Entity& entity, const ImportedMesh& imported);

/// Returns the surfaces by material index of the mesh. A material that Entity::materials or Entity::material
/// replaces comes from the scene, any other from the file.
///
/// imported  the entity's mesh, with its appearance.
/// warnings  receives images that are missing or have no texture coordinates, and material properties that
///           haarfield does not use.
/// errors    a name in Entity::materials that the file does not have; a scene's image on a material without
///           texture coordinates; unreadable images.
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
