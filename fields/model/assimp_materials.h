#pragma once
/// Materials of models that assimp reads.

#include "fields/mesh/mesh_material.h"

#include <assimp/scene.h>

#include <functional>
#include <string_view>

namespace haarfield {

/// Converts a material. Images that are not embedded have their names; their files are not searched for.
///
/// unused  called once for each property that haarfield does not use, such as "normal map".
MeshMaterial mesh_material(const aiScene& scene, const aiMaterial& material,
                           const std::function<void(std::string_view)>& unused);

/// Returns the index of the texture coordinates that the material's image uses.
unsigned uv_set(const aiMaterial& material);

/// Returns the map from texture coordinates to positions in the image, which applies the material's own
/// transformation (KHR_texture_transform).
std::function<Vec2f(const aiVector3D&)> uv_map(const aiMaterial& material);

}  // namespace haarfield
