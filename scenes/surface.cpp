#include "scenes/surface.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace haarfield {
namespace {

constexpr float dielectric = 0.04f;  ///< Reflectance at normal incidence.

void take_phong(const MeshMaterial& from, Material& material) {
    material.diffuse = from.diffuse;
    material.specular = from.specular;
    material.phong = 0;
    material.blinn = from.specular == Rgb(0.0f) ? 0.0f : 1.0f;
    material.roughness = 1 / std::clamp(from.exponent, 1.0f, 2000.0f);
}

/// Converts a metallic material. Returns the fraction of specular light that has the base colour.
float take_metallic(const MeshMaterial& from, Material& material) {
    const float alpha = from.roughness * from.roughness,
                exponent = (2 / std::max(alpha * alpha, 1e-6f) - 2) / 4;
    const Rgb tinted = from.diffuse * from.metallic, white = Rgb(dielectric * (1 - from.metallic));
    material.diffuse = from.diffuse * (1 - from.metallic);
    if (exponent < 1) {
        material.diffuse += tinted;
        for (int c = 0; c < 3; ++c) material.diffuse[c] = std::min(material.diffuse[c] + white[c], 1.0f);
        return 0;
    }
    material.shininess = std::min(exponent, 1000.0f);
    material.specular = tinted + white;
    material.phong = (material.shininess + 2) / 2;
    const float all = luminance(material.specular);
    return all > 0 ? luminance(tinted) / all : 0;
}

}  // namespace

Surface surface_of(const MeshMaterial& material) {
    Surface surface;
    surface.emission = material.emission;
    if (material.model == MeshMaterial::Model::none) return surface;
    surface.material.convention = LobeConvention::povray;
    surface.material.specular = Rgb(0.0f);
    if (material.model == MeshMaterial::Model::metallic)
        surface.tinted_specular = take_metallic(material, surface.material);
    else if (material.model == MeshMaterial::Model::phong)
        take_phong(material, surface.material);
    else
        surface.material.diffuse = material.diffuse;
    return surface;
}

LayeredRadiance layered_radiance(const Mesh& mesh, std::span<const Surface> surfaces,
                                 std::span<const Outgoing> radiance) {
    assert(radiance.size() == mesh.positions.size());
    LayeredRadiance layered;
    layered.textured.reserve(radiance.size());
    if (std::ranges::any_of(surfaces, &Surface::has_separate_specular))
        layered.added.assign(radiance.size(), Rgb(0.0f));
    for (std::size_t v = 0; v < radiance.size(); ++v) {
        const Surface& surface = surfaces[mesh.vertex_materials[v]];
        const float tinted = surface.has_separate_specular() ? surface.tinted_specular : 1;
        const Rgb added = radiance[v].specular * (1 - tinted);
        Rgb textured = radiance[v].diffuse + radiance[v].specular * tinted + surface.own_radiance();
        if (surface.coloured) textured *= mesh.colours[v];
        layered.textured.push_back(surface.texture ? textured : textured + added);
        if (surface.texture && !layered.added.empty()) layered.added[v] = added;
    }
    return layered;
}

std::vector<Rgb> tinted_specular_light(const Mesh& mesh, std::span<const Surface> surfaces,
                                       std::span<const Rgb> highlights) {
    assert(highlights.size() == mesh.positions.size());
    std::vector<Rgb> layered(highlights.begin(), highlights.end());
    for (std::size_t v = 0; v < layered.size(); ++v) {
        const Surface& surface = surfaces[mesh.vertex_materials[v]];
        if (surface.coloured)
            layered[v] *= mesh.colours[v] * surface.tinted_specular + Rgb(1 - surface.tinted_specular);
    }
    return layered;
}

std::vector<Rgb> vertex_tints(const Mesh& mesh, std::span<const Surface> surfaces) {
    if (!has_textures(surfaces) &&
        std::ranges::none_of(surfaces, [](const Surface& surface) { return surface.coloured; }))
        return {};
    // Barycentric coordinates: the centroid, and corners and edge midpoints moved slightly inwards.
    constexpr float third = 1.0f / 3, most = 0.8f, rest = 0.1f, half = 0.45f;
    constexpr std::array<std::array<float, 3>, 7> places{{{third, third, third},
                                                          {most, rest, rest},
                                                          {rest, most, rest},
                                                          {rest, rest, most},
                                                          {half, half, rest},
                                                          {rest, half, half},
                                                          {half, rest, half}}};
    std::vector<Rgb> sums(mesh.positions.size(), Rgb(0.0f));
    std::vector<float> weights(mesh.positions.size(), 0.0f);
    for (const std::array<std::uint32_t, 3>& corners : mesh.triangles) {
        const auto& [a, b, c] = corners;
        const Texture* texture = surfaces[mesh.vertex_materials[a]].texture.get();
        if (!texture) continue;
        Rgb mean(0.0f);
        for (const auto& [u, v, w] : places)
            mean += texture->colour_at(mesh.uvs[a] * u + mesh.uvs[b] * v + mesh.uvs[c] * w);
        const float area =
            (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).length();
        for (const std::uint32_t v : corners) {
            sums[v] += mean * (area / float(places.size()));
            weights[v] += area;
        }
    }
    std::vector<Rgb> tints(mesh.positions.size(), Rgb(1.0f));
    for (std::size_t v = 0; v < tints.size(); ++v) {
        if (weights[v] > 0) tints[v] = sums[v] / weights[v];
        if (surfaces[mesh.vertex_materials[v]].coloured) tints[v] *= mesh.colours[v];
    }
    return tints;
}

std::vector<Emitter> emitters_of(const Mesh& mesh, std::span<const Surface> surfaces) {
    // Corners, edge midpoints, and the centroid.
    constexpr std::array<std::array<float, 3>, 7> places{{{1, 0, 0},
                                                          {0, 1, 0},
                                                          {0, 0, 1},
                                                          {0.5f, 0.5f, 0},
                                                          {0, 0.5f, 0.5f},
                                                          {0.5f, 0, 0.5f},
                                                          {1 / 3.0f, 1 / 3.0f, 1 / 3.0f}}};
    std::vector<Emitter> emitters;
    for (const auto& triangle : mesh.triangles) {
        const Surface& surface = surfaces[mesh.vertex_materials[triangle[0]]];
        if (surface.emission == Rgb(0.0f)) continue;
        Emitter emitter;
        Rgb colour(0.0f);
        for (std::size_t k = 0; k < 3; ++k) emitter.corners[k] = mesh.positions[triangle[k]];
        for (const auto& place : places) {
            Rgb here(1.0f);
            const auto mean = [&](const auto& values) {
                return values[triangle[0]] * place[0] + values[triangle[1]] * place[1] +
                       values[triangle[2]] * place[2];
            };
            if (surface.coloured) here *= mean(mesh.colours);
            if (surface.texture) here *= surface.texture->colour_at(mean(mesh.uvs));
            colour += here / float(places.size());
        }
        emitter.radiance = surface.emission * colour;
        emitters.push_back(emitter);
    }
    return emitters;
}

bool has_textures(std::span<const Surface> surfaces) {
    return std::ranges::any_of(surfaces, [](const Surface& surface) { return surface.texture != nullptr; });
}

bool any_reflects(std::span<const Surface> surfaces) {
    return std::ranges::any_of(surfaces,
                               [](const Surface& surface) { return surface.reflection.is_there(); });
}

bool all_plain(std::span<const Surface> surfaces) {
    return std::ranges::all_of(surfaces, &Surface::is_plain);
}

std::vector<Material> materials_of(std::span<const Surface> surfaces) {
    std::vector<Material> materials;
    for (const Surface& surface : surfaces) materials.push_back(surface.material);
    return materials;
}

}  // namespace haarfield
