#include "scenes/files_in_memory.h"

namespace haarfield {
namespace {

template <class Given>
std::shared_ptr<const Given> found_in(
    const Scene& scene, std::map<std::filesystem::path, std::shared_ptr<const Given>> FilesInMemory::*kind,
    const std::filesystem::path& name) {
    if (!scene.given) return nullptr;
    const auto found = (*scene.given.*kind).find(name);
    return found == (*scene.given.*kind).end() ? nullptr : found->second;
}

}  // namespace

std::set<std::string> names_of(const FilesInMemory& given) {
    std::set<std::string> names;
    for (const auto& [name, mesh] : given.meshes) names.insert(name.string());
    for (const auto& [name, image] : given.images) names.insert(name.string());
    for (const auto& [name, image] : given.environments) names.insert(name.string());
    return names;
}

std::shared_ptr<const ModelFile> mesh_in_memory(const Scene& scene, const std::filesystem::path& name) {
    return found_in(scene, &FilesInMemory::meshes, name);
}

std::shared_ptr<const std::string> image_in_memory(const Scene& scene, const std::filesystem::path& name) {
    return found_in(scene, &FilesInMemory::images, name);
}

std::shared_ptr<const LatLongImage> environment_in_memory(const Scene& scene,
                                                          const std::filesystem::path& name) {
    return found_in(scene, &FilesInMemory::environments, name);
}

}  // namespace haarfield
