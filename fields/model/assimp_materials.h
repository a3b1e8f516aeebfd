#pragma once
/// Materials as assimp has read them.

#include "fields/mesh/mesh_material.h"

#include <assimp/scene.h>

#include <functional>
#include <string_view>

namespace haarfield {

/// What a file says of a material. Images that are not embedded have their names, and are not looked for.
///
/// unused  told what there is that haarfield does not use, such as "normal map", once each.
MeshMaterial mesh_material(const aiScene& scene, const aiMaterial& material,
                           const std::function<void(std::string_view)>& unused);

/// Which of a mesh's sets of texture coordinates the material's image wants.
unsigned uv_set(const aiMaterial& material);

/// Where in the image a texture coordinate lies, after the material's own transformation of it
/// (KHR_texture_transform).
std::function<Vec2f(const aiVector3D&)> uv_map(const aiMaterial& material);

}  // namespace haarfield
