#include "bridge/povray/textured_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <unordered_map>

#include "bridge/povray/povray_frame.h"

namespace haarfield {
namespace {

/// Offset of each side of a transparent sheet: the distance between both sides exceeds POV-Ray's tolerance of
/// 1e-4 units. [m]
constexpr float povray_parting = 1.5e-4f;

/// The appearance of a triangle's corner.
struct CornerAppearance {
    const TextureFile* image;  ///< Null: none.
    Colour textured, added;

    bool operator==(const CornerAppearance&) const = default;
    bool shines() const { return added != Colour{0, 0, 0}; }
};

struct CornerAppearanceHash {
    std::size_t operator()(const CornerAppearance& appearance) const {
        std::size_t hash = reinterpret_cast<std::uintptr_t>(appearance.image);
        for (const Colour& colour : {appearance.textured, appearance.added})
            for (const float channel : colour) hash = mixed_hash(hash, std::bit_cast<std::uint32_t>(channel));
        return hash ^ (hash >> 29);
    }
};

std::string rgb_text(const Colour& colour, float times = 1) {
    return fmt::format("<{:.6g},{:.6g},{:.6g}>", colour[0] * times, colour[1] * times, colour[2] * times);
}

std::string texture_text(const CornerAppearance& appearance, const std::string& finish) {
    if (!appearance.image)
        return fmt::format("texture{{pigment{{rgb{}}}finish{{{}}}}}", rgb_text(appearance.textured), finish);
    const auto layer = [&](const std::string& pigment, const Colour& light, float times) {
        return fmt::format("pigment{{{}}}finish{{{} emission{}}}", pigment, finish, rgb_text(light, times));
    };
    if (!appearance.shines())
        return fmt::format("texture{{{}}}", layer(appearance.image->pigment, appearance.textured, 1));
    // The average of the two, each twice as bright.
    return fmt::format("texture{{average texture_map{{[1 {}][1 {}]}}}}",
                       layer(appearance.image->pigment, appearance.textured, 2),
                       layer("rgb 1", appearance.added, 2));
}

/// Moves transparent triangles outwards. POV-Ray loses the whole mesh behind a hit that is closer to the
/// previous one than its tolerance, as a hit on the back of a sheet would be.
void part_cut_outs(Mesh& mesh, const std::vector<bool>& is_cut_out, float distance) {
    std::vector<bool> moves(mesh.positions.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (is_cut_out[t])
            for (const std::uint32_t corner : mesh.triangles[t]) moves[corner] = true;
    for (std::size_t v = 0; v < moves.size(); ++v)
        if (moves[v]) mesh.positions[v] += mesh.normals[v] * distance;
}

/// The distinct appearances of corners, numbered in order of occurrence.
class Appearances {
public:
    std::uint32_t number_of(const CornerAppearance& appearance) {
        const auto [entry, is_new] =
            numbers_.emplace(appearance, static_cast<std::uint32_t>(appearances_.size()));
        if (is_new) appearances_.push_back(appearance);
        return entry->second;
    }
    const std::vector<CornerAppearance>& all() const { return appearances_; }

private:
    std::unordered_map<CornerAppearance, std::uint32_t, CornerAppearanceHash> numbers_;
    std::vector<CornerAppearance> appearances_;
};

/// The uvs of vertices, unless all triangles are mapped, and three uvs of each mapped triangle.
struct UvLists {
    std::vector<Vec2f> uvs;
    std::vector<std::array<std::uint32_t, 3>> indices;
};

/// True if 16 bits resolve a triangle's image coordinates to a quarter of a texel of the finest image.
bool is_mappable(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle, int finest) {
    constexpr float most_texels = 8192;
    const Vec2f &a = mesh.uvs[triangle[0]], &b = mesh.uvs[triangle[1]], &c = mesh.uvs[triangle[2]];
    float span = 0;
    for (int axis = 0; axis < 2; ++axis)
        span = std::max(span, std::max({a[axis], b[axis], c[axis]}) - std::min({a[axis], b[axis], c[axis]}));
    return span * static_cast<float>(finest) <= most_texels;
}

/// magnified  as for is_sliver. The uvs of a sliver are those of its middle.
UvLists uv_lists(const Mesh& mesh, std::span<const std::uint32_t> mapped, const MappedLight& light,
                 double magnified) {
    UvLists lists{{}, mesh.triangles};
    if (mapped.size() < mesh.triangles.size()) lists.uvs = mesh.uvs;
    lists.uvs.reserve(lists.uvs.size() + 3 * mapped.size());
    for (std::size_t k = 0; k < mapped.size(); ++k) {
        std::array<Vec2f, 3> uvs = light.uvs(k);
        if (is_sliver(mesh, mesh.triangles[mapped[k]], magnified))
            uvs.fill((uvs[0] + uvs[1] + uvs[2]) / 3.0f);
        lists.indices[mapped[k]] = append_corner_uvs(lists.uvs, uvs);
    }
    return lists;
}

}  // namespace

bool maps_light(std::span<const Rgb> textured, std::span<const Rgb> added) {
    constexpr std::size_t most_shining_vertices = 100000;
    return textured.size() > most_textured_vertices || added.size() > most_shining_vertices;
}

TexturedMesh textured_mesh(const Mesh& baked, std::span<const Surface> surfaces,
                           std::span<const Rgb> textured, std::span<const Rgb> added,
                           const TextureFiles& files, bool maps_all, const std::string& object,
                           const std::string& stem, float scale) {
    assert(baked.uvs.size() == baked.positions.size());
    Mesh mesh = baked;
    const auto image_of = [&](std::uint32_t vertex) -> const TextureFile* {
        const Surface& surface = surfaces[mesh.vertex_materials[vertex]];
        return surface.texture ? &files.at(surface.texture.get()) : nullptr;
    };
    int finest = 0;  // [texels]
    for (const Surface& surface : surfaces)
        if (surface.texture) finest = std::max({finest, surface.texture->width, surface.texture->height});
    std::vector<bool> is_cut_out;
    std::vector<std::uint32_t> mapped;
    // The images and reflections of mapped triangles.
    std::vector<std::pair<const TextureFile*, Reflection>> mapped_images;
    const auto mapped_look = [&](std::uint32_t vertex) {
        return std::pair(image_of(vertex), surfaces[mesh.vertex_materials[vertex]].reflection);
    };
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Surface& surface = surfaces[mesh.vertex_materials[a]];
        is_cut_out.push_back(surface.texture &&
                             surface.texture->is_cut_out({mesh.uvs[a], mesh.uvs[b], mesh.uvs[c]}));
        const bool is_mirror = surface.reflection.is_there();
        if ((!maps_all && !is_cut_out.back() && !is_mirror) || !is_mappable(mesh, mesh.triangles[t], finest))
            continue;
        mapped.push_back(t);
        if (std::ranges::find(mapped_images, mapped_look(a)) == mapped_images.end())
            mapped_images.push_back(mapped_look(a));
    }
    part_cut_outs(mesh, is_cut_out, povray_parting / scale);

    TexturedMesh result;
    const std::vector<Colour> textured_light = clamped_colours(textured, result.clamped_vertices);
    std::uint64_t clamped_added = 0;
    const std::vector<Colour> added_light = clamped_colours(added, clamped_added);
    if (!mapped.empty()) result.mapped.emplace(mesh, mapped, textured_light, added_light, object, stem);
    const auto look_of = [&](std::uint32_t vertex) {
        return CornerAppearance{image_of(vertex), textured_light[vertex],
                                added_light.empty() ? Colour{0, 0, 0} : added_light[vertex]};
    };
    const auto mean_look = [&](const std::array<std::uint32_t, 3>& corners) {
        CornerAppearance mean = look_of(corners[0]);
        for (std::size_t c = 0; c < 3; ++c) {
            float textured_sum = 0, added_sum = 0;
            for (const std::uint32_t corner : corners) {
                textured_sum += look_of(corner).textured[c];
                added_sum += look_of(corner).added[c];
            }
            mean.textured[c] = textured_sum / 3;
            mean.added[c] = added_sum / 3;
        }
        return mean;
    };

    const PovrayFrame frame(mesh);
    std::string faces;
    auto out = std::back_inserter(faces);
    fmt::format_to(out, "face_indices {{ {}", mesh.triangles.size());
    // Mapped textures come first, one per image.
    Appearances appearances;
    const auto number_of = [&](const CornerAppearance& appearance) {
        return mapped_images.size() + appearances.number_of(appearance);
    };
    for (std::size_t t = 0, next = 0; t < mesh.triangles.size(); ++t) {
        const auto& triangle = mesh.triangles[t];
        const auto& [a, b, c] = triangle;
        fmt::format_to(out, ",\n<{},{},{}>,", a, b, c);
        // A face has three textures or one: two crash POV-Ray 3.7.
        if (next < mapped.size() && mapped[next] == t) {
            fmt::format_to(out, "{}",
                           std::ranges::find(mapped_images, mapped_look(a)) - mapped_images.begin());
            ++next;
        } else if (is_cut_out[t] || is_sliver(mesh, triangle, frame.magnified)) {
            fmt::format_to(out, "{}", number_of(mean_look(triangle)));
        } else {
            fmt::format_to(out, "{},{},{}", number_of(look_of(a)), number_of(look_of(b)),
                           number_of(look_of(c)));
        }
    }
    faces += " }\n";

    std::string& text = result.text;
    result.textures = mapped_images.size() + appearances.all().size();
    text.reserve(faces.size() + 200 * mesh.positions.size());
    text = "mesh2 {\n";
    frame.append_vertices(text, mesh);
    if (any_reflects(surfaces)) frame.append_normals(text, mesh);
    const UvLists own = result.mapped ? uv_lists(mesh, mapped, *result.mapped, frame.magnified) : UvLists();
    append_povray_uvs(text, result.mapped ? own.uvs : mesh.uvs);
    text += fmt::format("texture_list {{ {}", result.textures);
    for (const auto& [image, reflection] : mapped_images)
        text += ",\n" + result.mapped->texture(image, reflection);
    for (const CornerAppearance& appearance : appearances.all())
        text += ",\n" + texture_text(appearance, object + "_Finish");
    text += " }\n";
    text += faces;
    if (result.mapped) append_povray_indices(text, "uv_indices", own.indices);
    text += "uv_mapping\n" + povray_interior(surfaces);
    frame.append_inverse(text);
    return result;
}

}  // namespace haarfield
