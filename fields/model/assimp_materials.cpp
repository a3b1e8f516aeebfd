#include "fields/model/assimp_materials.h"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>

#include <algorithm>
#include <array>
#include <optional>

namespace haarfield {
namespace {

template <class T>
std::optional<T> found(const aiMaterial& material, const char* key, unsigned type = 0, unsigned index = 0) {
    T value{};
    if (material.Get(key, type, index, value) != aiReturn_SUCCESS) return std::nullopt;
    return value;
}

/// Clamps a channel, which may be any number in a file.
float clean(float value, float highest) {
    return value >= 0 ? std::min(value, highest) : 0;  // NaN becomes 0
}

Rgb clean(const aiColor3D& colour, float highest = 1) {
    return Rgb(clean(colour.r, highest), clean(colour.g, highest), clean(colour.b, highest));
}

std::optional<Rgb> colour(const aiMaterial& material, const char* key, unsigned type, unsigned index,
                          float highest = 1) {
    const auto value = found<aiColor3D>(material, key, type, index);
    if (!value) return std::nullopt;
    return clean(*value, highest);
}

constexpr std::array image_types{aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE};

/// Returns the type of the first texture that defines the colour.
std::optional<aiTextureType> colour_type(const aiMaterial& material) {
    for (const aiTextureType type : image_types)
        if (material.GetTextureCount(type) > 0) return type;
    return std::nullopt;
}

MeshImage image_of(const aiScene& scene, const aiMaterial& material, aiTextureType type) {
    MeshImage image;
    aiString name;
    if (material.GetTexture(type, 0, &name) != aiReturn_SUCCESS) return image;
    image.name = name.C_Str();
    if (const aiTexture* embedded = scene.GetEmbeddedTexture(name.C_Str())) {
        // The height is not 0 for raw texels, which no supported format embeds.
        if (embedded->mHeight == 0 && embedded->mWidth > 0)
            image.bytes = std::make_shared<const std::string>(reinterpret_cast<const char*>(embedded->pcData),
                                                              embedded->mWidth);
        if (embedded->mFilename.length > 0) image.name = embedded->mFilename.C_Str();
    }
    return image;
}

bool has_emission_map(const aiMaterial& material) {
    return material.GetTextureCount(aiTextureType_EMISSIVE) > 0 ||
           material.GetTextureCount(aiTextureType_EMISSION_COLOR) > 0;
}

void tell_unused(const aiMaterial& material, const std::function<void(std::string_view)>& unused) {
    constexpr std::array<std::pair<aiTextureType, std::string_view>, 12> maps{
        {{aiTextureType_NORMALS, "normal map"},
         {aiTextureType_NORMAL_CAMERA, "normal map"},
         {aiTextureType_HEIGHT, "bump map"},
         {aiTextureType_DISPLACEMENT, "displacement map"},
         {aiTextureType_SPECULAR, "specular map"},
         {aiTextureType_SHININESS, "shininess map"},
         {aiTextureType_AMBIENT, "ambient map"},
         {aiTextureType_AMBIENT_OCCLUSION, "occlusion map"},
         {aiTextureType_LIGHTMAP, "occlusion or light map"},
         {aiTextureType_REFLECTION, "reflection map"},
         {aiTextureType_SHEEN, "sheen map"},
         {aiTextureType_CLEARCOAT, "clear coat map"}}};
    for (const auto& [type, name] : maps)
        if (material.GetTextureCount(type) > 0) unused(name);
    if (has_emission_map(material)) unused("emission map, so that no light is emitted,");
    if (found<float>(material, AI_MATKEY_CLEARCOAT_FACTOR).value_or(0) > 0) unused("clear coat");
    if (found<float>(material, AI_MATKEY_TRANSMISSION_FACTOR).value_or(0) > 0) unused("transmission");
    if (colour(material, AI_MATKEY_SHEEN_COLOR_FACTOR).value_or(Rgb(0.0f)) != Rgb(0.0f)) unused("sheen");
}

void take_alpha(const aiScene& scene, const aiMaterial& material, MeshMaterial& made,
                const std::function<void(std::string_view)>& unused) {
    if (const auto mode = found<aiString>(material, AI_MATKEY_GLTF_ALPHAMODE)) {
        const std::string_view text = mode->C_Str();
        made.alpha = text == "MASK"    ? AlphaMode::mask
                     : text == "BLEND" ? AlphaMode::blend
                                       : AlphaMode::opaque;
        made.alpha_cutoff = clean(found<float>(material, AI_MATKEY_GLTF_ALPHACUTOFF).value_or(0.5f), 1);
    } else if (material.GetTextureCount(aiTextureType_OPACITY) > 0) {
        made.alpha = AlphaMode::mask;
        made.opacity_map = image_of(scene, material, aiTextureType_OPACITY);
    } else {
        made.alpha = AlphaMode::mask;  // if the colour's image has an alpha channel
    }
    if (found<float>(material, AI_MATKEY_OPACITY).value_or(1) < 1) unused("opacity below 1");
}

}  // namespace

MeshMaterial mesh_material(const aiScene& scene, const aiMaterial& material,
                           const std::function<void(std::string_view)>& unused) {
    constexpr float brightest = 1e6f;
    MeshMaterial made;
    const auto base = colour(material, AI_MATKEY_BASE_COLOR),
               diffuse = colour(material, AI_MATKEY_COLOR_DIFFUSE);
    const auto metallic = found<float>(material, AI_MATKEY_METALLIC_FACTOR);
    const int shading = found<int>(material, AI_MATKEY_SHADING_MODEL).value_or(aiShadingMode_Phong);
    // Exporters write a factor of 1 next to a map. Without the map, the whole surface would emit light.
    if (!has_emission_map(material))
        made.emission = colour(material, AI_MATKEY_COLOR_EMISSIVE, brightest).value_or(Rgb(0.0f)) *
                        clean(found<float>(material, AI_MATKEY_EMISSIVE_INTENSITY).value_or(1), brightest);
    if (base || metallic) {
        made.model = MeshMaterial::Model::metallic;
        made.diffuse = base.value_or(diffuse.value_or(Rgb(1.0f)));
        made.metallic = clean(metallic.value_or(1), 1);
        made.roughness = clean(found<float>(material, AI_MATKEY_ROUGHNESS_FACTOR).value_or(1), 1);
        made.surface_map = image_of(scene, material, aiTextureType_METALNESS);
        if (made.surface_map.name.empty())
            made.surface_map = image_of(scene, material, aiTextureType_UNKNOWN);
    } else if (diffuse) {
        made.model = MeshMaterial::Model::phong;
        made.diffuse = *diffuse;
        const bool has_specular = shading != aiShadingMode_Gouraud && shading != aiShadingMode_Flat &&
                                  shading != aiShadingMode_NoShading;
        made.exponent = clean(found<float>(material, AI_MATKEY_SHININESS).value_or(0), brightest);
        if (has_specular && made.exponent > 0)
            made.specular = colour(material, AI_MATKEY_COLOR_SPECULAR).value_or(Rgb(0.0f));
    } else {
        return made;
    }
    if (const auto type = colour_type(material)) made.image = image_of(scene, material, *type);
    // Some exporters leave the colour black if there is an image.
    if (!made.image.name.empty() && made.diffuse == Rgb(0.0f)) made.diffuse = Rgb(1.0f);
    if (made.model == MeshMaterial::Model::metallic && shading == aiShadingMode_Unlit) {
        made.emission = made.diffuse;
        made.diffuse = Rgb(0.0f);
        made.metallic = 0;
        made.roughness = 1;
    }
    take_alpha(scene, material, made, unused);
    tell_unused(material, unused);
    return made;
}

unsigned uv_set(const aiMaterial& material) {
    const auto type = colour_type(material);
    if (!type) return 0;
    const int set = found<int>(material, AI_MATKEY_UVWSRC(*type, 0)).value_or(0);
    return set > 0 ? static_cast<unsigned>(set) : 0;
}

std::function<Vec2f(const aiVector3D&)> uv_map(const aiMaterial& material) {
    const auto as_it_is = [](const aiVector3D& uv) { return Vec2f(uv.x, uv.y); };
    const auto type = colour_type(material);
    if (!type) return as_it_is;
    const auto transform = found<aiUVTransform>(material, AI_MATKEY_UVTRANSFORM(*type, 0));
    if (!transform) return as_it_is;
    // assimp rotates about the image's centre, and compensates in the translation for glTF's rotation about
    // the upper left corner. This recovers glTF's offset, rotation and scale.
    const double angle = -double(transform->mRotation), cosine = std::cos(angle), sine = std::sin(angle),
                 scale_u = double(transform->mScaling.x), scale_v = double(transform->mScaling.y),
                 offset_u = double(transform->mTranslation.x) - 0.5 * scale_u * (1 - cosine + sine),
                 offset_v =
                     1 - scale_v + 0.5 * scale_v * (sine + cosine - 1) - double(transform->mTranslation.y);
    return [=](const aiVector3D& uv) {
        const double u = scale_u * double(uv.x), v = scale_v * (1 - double(uv.y));
        return Vec2f(float(cosine * u + sine * v + offset_u), float(1 - (cosine * v - sine * u + offset_v)));
    };
}

}  // namespace haarfield
