#include "bridge/povray/coloured_mesh.h"

#include "bridge/povray/povray_frame.h"
#include "bridge/povray/triangle_atlas.h"

#include <Imath/half.h>
#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

namespace haarfield {
namespace {

struct ColourHash {
    std::size_t operator()(const Colour& c) const {
        std::size_t hash = 0;
        for (float channel : c) hash = mixed_hash(hash, std::bit_cast<std::uint32_t>(channel));
        return hash ^ (hash >> 29);
    }
};

/// The distinct colours, in the order of their first vertex, and the index of each vertex's colour.
struct Palette {
    std::vector<Colour> colours;
    std::vector<std::uint32_t> of_vertex;
};

Palette palette(const std::vector<Colour>& of_vertices) {
    Palette result;
    result.of_vertex.reserve(of_vertices.size());
    std::unordered_map<Colour, std::uint32_t, ColourHash> number;
    for (const Colour& colour : of_vertices) {
        const auto [entry, is_new] =
            number.emplace(colour, static_cast<std::uint32_t>(result.colours.size()));
        if (is_new) result.colours.push_back(colour);
        result.of_vertex.push_back(entry->second);
    }
    return result;
}

void append_textured_faces(std::string& text, const Mesh& mesh, const Palette& colours, double magnified,
                           const std::string& finish) {
    auto out = std::back_inserter(text);
    fmt::format_to(out, "texture_list {{ {}", colours.colours.size());
    for (const auto& c : colours.colours)
        fmt::format_to(out, ",\ntexture{{pigment{{rgb<{:.6g},{:.6g},{:.6g}>}}finish{{{}}}}}", c[0], c[1],
                       c[2], finish);
    fmt::format_to(out, " }}\nface_indices {{ {}", mesh.triangles.size());
    // A face has three textures or one: two crash POV-Ray 3.7.
    for (const auto& triangle : mesh.triangles) {
        const auto& [a, b, c] = triangle;
        fmt::format_to(out, ",\n<{},{},{}>,{}", a, b, c, colours.of_vertex[a]);
        if (!is_sliver(mesh, triangle, magnified))
            fmt::format_to(out, ",{},{}", colours.of_vertex[b], colours.of_vertex[c]);
    }
    text += " }\n";
}

/// numbers  by triangle: the number of its texture; or none.
void append_mapped_faces(std::string& text, const Mesh& mesh, const TriangleAtlas& atlas,
                         const std::string& texture_list, const std::vector<std::size_t>& numbers) {
    std::vector<Vec2f> uvs;
    std::vector<std::array<std::uint32_t, 3>> uv_indices;
    uvs.reserve(3 * mesh.triangles.size());
    uv_indices.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        uv_indices.push_back(append_corner_uvs(uvs, atlas.uvs(t)));
    append_povray_uvs(text, uvs);
    if (numbers.empty()) {
        append_povray_indices(text, "face_indices", mesh.triangles);
    } else {
        text += texture_list;
        auto out = std::back_inserter(text);
        fmt::format_to(out, "face_indices {{ {}", mesh.triangles.size());
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            fmt::format_to(out, ",\n<{},{},{}>,{}", a, b, c, numbers[t]);
        }
        text += " }\n";
    }
    append_povray_indices(text, "uv_indices", uv_indices);
}

}  // namespace

ColourStorage colour_storage(std::span<const Rgb> colours) {
    constexpr std::size_t most_textures = 200000;
    if (colours.size() <= most_textures) return ColourStorage::textures;
    const auto has_hue = [](const Rgb& c) { return c.x != c.y || c.y != c.z; };
    if (std::none_of(colours.begin(), colours.end(), has_hue)) return ColourStorage::grey_textures;
    return colours.size() <= most_textured_vertices ? ColourStorage::textures : ColourStorage::atlas;
}

ColouredMesh coloured_mesh(const Mesh& mesh, std::span<const Rgb> colours, ColourStorage storage,
                           const std::string& finish, const std::string& atlas_file,
                           std::span<const Surface> surfaces) {
    const bool has_mirrors = any_reflects(surfaces);
    assert(!has_mirrors || storage == ColourStorage::atlas);
    ColouredMesh result;
    std::vector<Colour> of_vertices = clamped_colours(colours, result.clamped_vertices);
    const PovrayFrame frame(mesh);
    std::string& text = result.text;
    text.reserve(128 * mesh.positions.size() + 32 * mesh.triangles.size());
    text = "mesh2 {\n";
    frame.append_vertices(text, mesh);
    if (storage == ColourStorage::atlas) {
        const TriangleAtlas atlas(mesh.triangles.size());
        const std::string pigment = atlas.pigment(fmt::format("exr \"{}\"", atlas_file));
        std::vector<std::string> textures;
        std::vector<std::size_t> numbers;
        if (has_mirrors) {
            frame.append_normals(text, mesh);
            for (const auto& triangle : mesh.triangles) {
                const Surface& surface = surfaces[mesh.vertex_materials[triangle[0]]];
                const std::string texture =
                    fmt::format("texture {{ uv_mapping {} finish {{ {}{} }} }}", pigment, finish,
                                povray_reflection(surface.reflection));
                const auto known = std::ranges::find(textures, texture);
                numbers.push_back(std::size_t(known - textures.begin()));
                if (known == textures.end()) textures.push_back(texture);
            }
        }
        append_mapped_faces(
            text, mesh, atlas,
            fmt::format("texture_list {{ {},\n{} }}\n", textures.size(), fmt::join(textures, ",\n")),
            numbers);
        frame.append_inverse(text);
        result.atlas = atlas.image([&](std::size_t t) {
            const auto& [a, b, c] = mesh.triangles[t];
            return std::array{rgb(of_vertices[a]), rgb(of_vertices[b]), rgb(of_vertices[c])};
        });
        result.textures = std::max<std::size_t>(1, textures.size());
        if (has_mirrors)
            text += povray_interior(surfaces);
        else
            text += fmt::format("texture {{\n  uv_mapping {}\n  finish {{ {} }}\n}}\n", pigment, finish);
        return result;
    }
    if (storage == ColourStorage::grey_textures)
        for (Colour& colour : of_vertices)
            for (float& channel : colour) channel = Imath::half(channel);
    const Palette textures = palette(of_vertices);
    result.textures = textures.colours.size();
    append_textured_faces(text, mesh, textures, frame.magnified, finish);
    frame.append_inverse(text);
    return result;
}

}  // namespace haarfield
