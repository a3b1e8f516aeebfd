#include "scenes/entity_surfaces.h"

#include <fmt/format.h>

#include <algorithm>

#include "fields/base/names.h"
#include "scenes/files_in_memory.h"

namespace haarfield {
namespace {

/// Returns the name of the scene's material that replaces a material of the file; empty if there is none.
const std::string& scene_material(const Entity& entity, const std::string& name) {
    const auto mapped = entity.materials.find(name);
    return mapped != entity.materials.end() ? mapped->second : entity.material;
}

/// Replaces the material of a surface, which has its image already.
void set_material(const SceneMaterial& material, Surface& surface) {
    surface.material = material;
    surface.emission = material.emission;
    surface.ambient = material.ambient;
    surface.reflection = material.reflection;
    const Rgb tint = Rgb(1 - material.reflection.metallic) + material.pigment * material.reflection.metallic;
    surface.reflection.at_normal *= tint;
    surface.reflection.at_grazing *= tint;
    surface.reflection.metallic = 0;
    surface.tinted_specular =
        (surface.texture || surface.coloured) && material.convention == LobeConvention::povray
            ? material.metallic
            : 0;
}

/// Makes the surfaces of an entity's mesh.
class SurfaceMaker {
public:
    SurfaceMaker(const Scene& scene, const Entity& entity, const ImportedMesh& imported, TextureShelf& shelf,
                 ModelWarnings& warnings)
        : scene_(scene), entity_(entity), imported_(imported), shelf_(shelf), warnings_(warnings) {}

    Result<std::vector<Surface>> surfaces() {
        const std::vector<std::string>& names = imported_.mesh.material_names;
        for (const auto& [name, material] : entity_.materials)
            if (std::ranges::find(names, name) == names.end())
                return Error{
                    entity_.mesh.string(),
                    fmt::format("found no material \"{}\", which entity {} names; expected one of {}", name,
                                entity_.name, quoted_list(names))};
        std::vector<Surface> surfaces;
        for (std::size_t m = 0; m < names.size(); ++m) {
            const std::string& wanted = scene_material(entity_, names[m]);
            HF_TRY(Surface surface, wanted.empty() ? of_file(m) : of_scene(scene_.materials.at(wanted), m));
            surfaces.push_back(std::move(surface));
        }
        return surfaces;
    }

private:
    Result<Surface> of_scene(const SceneMaterial& material, std::size_t number) {
        Surface surface;
        surface.coloured = material.vertex_colours && imported_.coloured[number];
        set_material(material, surface);
        if (material.image.empty()) return surface;
        if (!imported_.mapped[number])
            return Error{entity_.mesh.string(),
                         fmt::format("found no texture coordinates for image {} of material \"{}\"",
                                     material.image.string(), imported_.mesh.material_names[number])};
        HF_TRY(const std::shared_ptr<const Texture> texture,
               shelf_.texture({{material.image.filename().string(), material.image,
                                image_in_memory(scene_, material.image)},
                               {},
                               AlphaMode::blend}));
        surface.texture = texture;
        set_material(material, surface);
        return surface;
    }

    Result<Surface> of_file(std::size_t number) {
        MeshMaterial described = imported_.materials[number];
        if (described.surface_map.is_there()) {
            HF_TRY(const Rgb mean, mean_of_numbers(described.surface_map));
            described.roughness *= mean.y;
            described.metallic *= mean.z;
        }
        Surface surface = surface_of(described);
        surface.coloured = imported_.coloured[number];
        for (const MeshImage* image : {&described.image, &described.opacity_map})
            if (!image->name.empty() && !image->is_there())
                warnings_.add_missing_image(entity_.mesh, image->name);
        if (!described.image.is_there() && !described.opacity_map.is_there()) return surface;
        if (!imported_.mapped[number]) {
            warnings_.add_unmapped_image(entity_.mesh, described.image.name);
            return surface;
        }
        HF_TRY(const std::shared_ptr<const Texture> texture,
               shelf_.texture(
                   {described.image, described.opacity_map, described.alpha, described.alpha_cutoff}));
        surface.texture = texture;
        return surface;
    }

    const Scene& scene_;
    const Entity& entity_;
    const ImportedMesh& imported_;
    TextureShelf& shelf_;
    ModelWarnings& warnings_;
};

}  // namespace

Result<std::shared_ptr<const Texture>> TextureShelf::texture(const TextureSource& source) {
    for (const auto& [known, texture] : textures_)
        if (known.image == source.image && known.opacity_map == source.opacity_map &&
            known.alpha == source.alpha && known.alpha_cutoff == source.alpha_cutoff)
            return texture;
    HF_TRY(Texture read, read_texture(source));
    textures_.emplace_back(source, std::make_shared<const Texture>(std::move(read)));
    return textures_.back().second;
}

bool uses_file_materials(const Entity& entity, const ImportedMesh& imported) {
    return std::ranges::any_of(imported.mesh.material_names,
                               [&](const std::string& name) { return scene_material(entity, name).empty(); });
}

Result<std::vector<Surface>> entity_surfaces(const Scene& scene, const Entity& entity,
                                             const ImportedMesh& imported, TextureShelf& shelf,
                                             ModelWarnings& warnings) {
    return SurfaceMaker(scene, entity, imported, shelf, warnings).surfaces();
}

std::vector<Surface> with_scene_materials(const Scene& scene, const Entity& entity,
                                          std::span<const std::string> names, std::vector<Surface> prepared) {
    for (std::size_t m = 0; m < prepared.size(); ++m)
        if (const std::string& name = scene_material(entity, names[m]); !name.empty())
            set_material(scene.materials.at(name), prepared[m]);
    return prepared;
}

}  // namespace haarfield
