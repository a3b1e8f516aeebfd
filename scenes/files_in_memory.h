#pragma once
/// Meshes and images in memory that a program supplies in place of files.

#include "fields/model/model_file.h"
#include "scenes/scene.h"

#include <map>
#include <memory>
#include <set>

namespace haarfield {

/// Data in memory by the name under which a scene refers to it. Such a name is not looked up on disk.
struct FilesInMemory {
    std::map<std::filesystem::path, std::shared_ptr<const ModelFile>> meshes;  ///< For Entity::mesh.
    /// For SceneMaterial::image: the bytes of an image file, such as png_bytes returns.
    std::map<std::filesystem::path, std::shared_ptr<const std::string>> images;
    /// For EnvironmentDescription::image, as read_environment_image returns it.
    std::map<std::filesystem::path, std::shared_ptr<const LatLongImage>> environments;
};

/// Returns the names of all meshes, images and environments.
std::set<std::string> names_of(const FilesInMemory& given);

/// Returns the data that a scene supplies under a name; null if the name refers to a file.
std::shared_ptr<const ModelFile> mesh_in_memory(const Scene& scene, const std::filesystem::path& name);
std::shared_ptr<const std::string> image_in_memory(
    const Scene& scene,
    const std::filesystem::path& name);  ///< As mesh_in_memory.
std::shared_ptr<const LatLongImage> environment_in_memory(
    const Scene& scene,
    const std::filesystem::path& name);  ///< As mesh_in_memory.

}  // namespace haarfield
