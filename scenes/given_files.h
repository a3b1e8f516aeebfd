#pragma once
/// What a program gives in place of files: meshes and images that it holds in memory.

#include "fields/model/model_file.h"
#include "scenes/scene.h"

#include <map>
#include <memory>
#include <set>

namespace haarfield {

/// By the names under which a scene has them: no file is looked for under these.
struct GivenFiles {
    std::map<std::filesystem::path, std::shared_ptr<const ModelFile>> meshes;  ///< Of Entity::mesh.
    /// Of SceneMaterial::image: the bytes of an image file, such as png_bytes makes.
    std::map<std::filesystem::path, std::shared_ptr<const std::string>> images;
    /// Of EnvironmentDescription::image, as read_environment_image has them.
    std::map<std::filesystem::path, std::shared_ptr<const LatLongImage>> environments;
};

/// Of all of them.
std::set<std::string> names_of(const GivenFiles& given);

/// What a scene is given under a name; null: it is a file.
std::shared_ptr<const ModelFile> given_mesh(const Scene& scene, const std::filesystem::path& name);
std::shared_ptr<const std::string> given_image(const Scene& scene,
                                               const std::filesystem::path& name);  ///< Likewise.
std::shared_ptr<const LatLongImage> given_environment(const Scene& scene,
                                                      const std::filesystem::path& name);  ///< Likewise.

}  // namespace haarfield
