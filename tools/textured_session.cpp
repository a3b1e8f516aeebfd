#include "tools/textured_session.h"

#include "scenes/bake_search.h"

#include <algorithm>

namespace haarfield {
namespace {

bool has_layers(std::span<const std::vector<Surface>> surfaces) {
    return std::ranges::any_of(surfaces, [](const std::vector<Surface>& of_entity) {
        return std::ranges::any_of(of_entity, &Surface::has_separate_specular);
    });
}

/// Returns the materials of surfaces without the specular lobes that lie on top of textures.
std::vector<Material> matt_materials(std::span<const Surface> surfaces) {
    std::vector<Material> materials = materials_of(surfaces);
    for (std::size_t m = 0; m < materials.size(); ++m)
        if (surfaces[m].has_separate_specular()) materials[m].specular = Rgb(0.0f);
    return materials;
}

}  // namespace

std::vector<std::vector<Surface>> surfaces_of(const SceneEntities& entities) {
    std::vector<std::vector<Surface>> surfaces;
    for (const auto& entity : entities.entities) surfaces.push_back(entity->surfaces);
    return surfaces;
}

TexturedSession::TexturedSession(ShadedScene scene, std::span<const std::vector<Surface>> surfaces,
                                 const RenderSettings& settings, const TransferSettings& transfer)
    : all_(scene, settings, transfer) {
    if (!has_layers(surfaces)) return;
    for (std::size_t e = 0; e < surfaces.size(); ++e)
        scene.entities[e].materials = matt_materials(surfaces[e]);
    matte_.emplace(std::move(scene), settings, transfer);
}

bool TexturedSession::set_materials(std::span<const std::vector<Surface>> surfaces) {
    if (has_layers(surfaces) != matte_.has_value()) return false;
    for (std::size_t e = 0; e < surfaces.size(); ++e) {
        all_.set_materials(e, materials_of(surfaces[e]));
        if (matte_) matte_->set_materials(e, matt_materials(surfaces[e]));
    }
    return true;
}

Result<BakeError> TexturedSession::error(const SceneEntities& entities, const Camera& camera,
                                         Preview& preview, const Progress& progress) {
    constexpr double accuracy = 0.01;
    SceneRadiance shown;
    for (std::size_t i = 0; i < instances().size(); ++i) shown.push_back(outgoing(i));
    const auto pixels = preview.points(camera, preview_instances(entities, scene()));
    return all_.error(shown, displayed_points(entities, scene(), pixels), accuracy, progress);
}

std::vector<Outgoing> TexturedSession::outgoing(std::size_t instance) const {
    std::vector<Outgoing> result;
    const std::vector<Rgb>& all = all_.radiance()[instance];
    for (std::size_t v = 0; v < all.size(); ++v) {
        const Rgb specular = matte_ ? without_negative(all[v] - matte_->radiance()[instance][v]) : Rgb(0.0f);
        result.push_back({all[v] - specular, specular});
    }
    return result;
}

}  // namespace haarfield
