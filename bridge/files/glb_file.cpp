#include "bridge/files/glb_file.h"

#include "fields/file/write_file.h"
#include "scenes/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace haarfield {
namespace {

static_assert(std::endian::native == std::endian::little);  // as in glTF

using Json = nlohmann::ordered_json;

constexpr int float_components = 5126, index_components = 5125;  // glTF's names of GL's constants
constexpr int vertex_target = 34962, index_target = 34963;

/// The binary chunk and its description.
struct Buffer {
    std::string bytes;
    Json views = Json::array(), accessors = Json::array();

    /// Appends items without padding; item sizes are multiples of four bytes. Returns the index of their
    /// accessor.
    template <class T>
    std::size_t append(std::span<const T> items, int target, Json accessor) {
        static_assert(sizeof(T) % 4 == 0);
        const std::size_t size = items.size_bytes();
        views.push_back(
            {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}, {"target", target}});
        bytes.append(reinterpret_cast<const char*>(items.data()), size);
        accessor["bufferView"] = views.size() - 1;
        accessors.push_back(std::move(accessor));
        return accessors.size() - 1;
    }

    std::size_t append_vectors(std::span<const Vec3f> vectors) {
        return append(vectors, vertex_target,
                      {{"componentType", float_components}, {"count", vectors.size()}, {"type", "VEC3"}});
    }

    /// Appends the bytes of an image file, padded with zeros to a multiple of four. Returns the index of
    /// their view.
    std::size_t append_file(std::string_view file) {
        views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", file.size()}});
        bytes += file;
        bytes.resize((bytes.size() + 3) / 4 * 4);
        return views.size() - 1;
    }
};

Json json_of(const Vec3f& v) {
    return {v.x, v.y, v.z};
}

/// The image file of a texture.
struct ImageFile {
    std::string bytes;
    const char* type = nullptr;  ///< Its media type.
    std::size_t material = 0;    ///< The index of the material that displays it.
};
using ImageFiles = std::map<const Texture*, ImageFile>;

Result<ImageFiles> image_files(std::span<const BakedInstance> instances) {
    ImageFiles files;
    for (const BakedInstance& instance : instances)
        for (const Surface& surface : instance.surfaces) {
            const Texture* const texture = surface.texture.get();
            if (!texture || files.contains(texture)) continue;
            const std::size_t material = 1 + files.size();
            if (!texture->jpeg.empty()) {
                files[texture] = {texture->jpeg, "image/jpeg", material};
            } else if (!texture->png.empty()) {
                files[texture] = {texture->png, "image/png", material};
            } else {
                HF_TRY(std::string png,
                       png_bytes(texture->texels, texture->width, texture->height, texture->has_alpha));
                files[texture] = {std::move(png), "image/png", material};
            }
        }
    return files;
}

/// Returns a material that displays COLOR_0, multiplied by an image if there is one.
Json unlit_material(const std::string& name, const Texture* texture, std::size_t number) {
    Json material{{"name", name},
                  {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                  {"extensions", {{"KHR_materials_unlit", Json::object()}}}};
    if (!texture) return material;
    material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", number}};
    if (texture->has_alpha) {
        const bool is_mask = std::ranges::all_of(
            texture->texels, [](const auto& texel) { return texel[3] == 0 || texel[3] == 255; });
        material["alphaMode"] = is_mask ? "MASK" : "BLEND";
    }
    return material;
}

/// The materials, and the textures and images that they use.
struct Appearance {
    Json materials = Json::array({unlit_material("baked radiance", nullptr, 0)}), textures = Json::array(),
         images = Json::array();
};

Appearance appearance_of(const ImageFiles& files, Buffer& buffer) {
    std::vector<const Texture*> order(files.size());  // by material
    for (const auto& [texture, file] : files) order[file.material - 1] = texture;
    Appearance made;
    for (const Texture* texture : order) {
        const ImageFile& file = files.at(texture);
        made.images.push_back({{"name", texture->name},
                               {"mimeType", file.type},
                               {"bufferView", buffer.append_file(file.bytes)}});
        made.textures.push_back({{"source", made.images.size() - 1}});
        made.materials.push_back(
            unlit_material("baked radiance on " + texture->name, texture, made.textures.size() - 1));
    }
    return made;
}

/// Returns COLOR_0 of a vertex: the light that an image multiplies. Specular radiance is added after the
/// image, but glTF cannot express that. It is therefore divided by the image's mean around the vertex.
///
/// tints  that mean, by vertex; empty if there is no specular radiance.
Rgb light_at(const BakedInstance& instance, std::span<const Rgb> tints, std::size_t vertex) {
    constexpr float darkest = 0.04f;
    if (tints.empty()) return instance.radiance[vertex];
    Rgb light = instance.radiance[vertex];
    for (int c = 0; c < 3; ++c) light[c] += instance.added[vertex][c] / std::max(tints[vertex][c], darkest);
    return light;
}

/// Returns the means of the images around the vertices, or nothing if there is no specular radiance.
std::vector<Rgb> image_tints(const BakedInstance& instance) {
    if (instance.added.empty() || !has_textures(instance.surfaces)) return {};
    std::vector<Surface> surfaces(instance.surfaces.begin(), instance.surfaces.end());
    // The radiance already contains vertex colours.
    for (Surface& surface : surfaces) surface.coloured = false;
    return vertex_tints(*instance.mesh, surfaces);
}

/// Returns the primitives that instances of one mesh share: one per image, and one for triangles without an
/// image.
Json shared_primitives(const BakedInstance& instance, const ImageFiles& files, Buffer& buffer) {
    const Mesh& mesh = *instance.mesh;
    const std::size_t positions = buffer.append_vectors(mesh.positions);
    const Bounds bounds = mesh_bounds(mesh);
    buffer.accessors[positions]["min"] = json_of(bounds.lower);
    buffer.accessors[positions]["max"] = json_of(bounds.upper);
    const std::size_t normals = buffer.append_vectors(mesh.normals);
    Json attributes{{"POSITION", positions}, {"NORMAL", normals}};
    if (has_textures(instance.surfaces)) {
        std::vector<Vec2f> places;  // v points down in glTF
        for (const Vec2f& uv : mesh.uvs) places.emplace_back(uv.x, 1 - uv.y);
        attributes["TEXCOORD_0"] =
            buffer.append(std::span<const Vec2f>(places), vertex_target,
                          {{"componentType", float_components}, {"count", places.size()}, {"type", "VEC2"}});
    }
    std::map<std::size_t, std::vector<std::array<std::uint32_t, 3>>> triangles;  // by material
    for (const auto& triangle : mesh.triangles) {
        const Texture* const texture = texture_of(instance, triangle);
        triangles[texture ? files.at(texture).material : 0].push_back(triangle);
    }
    Json primitives = Json::array();
    for (const auto& [material, own] : triangles) {
        const std::size_t indices = buffer.append(
            std::span(own), index_target,
            {{"componentType", index_components}, {"count", 3 * own.size()}, {"type", "SCALAR"}});
        primitives.push_back({{"attributes", attributes}, {"indices", indices}, {"material", material}});
    }
    return primitives;
}

Json node_of(const BakedInstance& instance, std::size_t mesh) {
    Json node{{"name", instance.name}, {"mesh", mesh}};
    if (instance.placement == Placement()) return node;
    const std::array<float, 12> columns = instance.placement.columns();
    Json matrix = Json::array();
    for (std::size_t column = 0; column < 4; ++column) {
        for (std::size_t row = 0; row < 3; ++row) matrix.push_back(columns[3 * column + row]);
        matrix.push_back(column == 3 ? 1 : 0);
    }
    node["matrix"] = std::move(matrix);
    return node;
}

/// Returns `_NAME`, the glTF name of an application's attribute.
std::string attribute_name(const std::string& pass) {
    std::string name = "_";
    for (const char c : pass) name += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    return name;
}

std::size_t append_pass(const VertexValues& pass, Buffer& buffer) {
    const Json accessor{{"componentType", float_components}, {"count", pass.values.size()}};
    const auto appended = [&](auto items, const char* type) {
        Json typed = accessor;
        typed["type"] = type;
        return buffer.append(items, vertex_target, std::move(typed));
    };
    if (!pass.is_scalar) return appended(pass.values, "VEC3");
    std::vector<float> numbers;
    for (const Rgb& value : pass.values) numbers.push_back(value.x);
    return appended(std::span<const float>(numbers), "SCALAR");
}

void append_number(std::string& bytes, std::size_t number) {
    const auto value = static_cast<std::uint32_t>(number);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Returns an upper bound of the buffer's size. [bytes]
std::uint64_t buffer_size(std::span<const BakedInstance> instances, const ImageFiles& files) {
    std::uint64_t size = 0;
    for (const auto& [texture, file] : files) size += file.bytes.size() + 3;
    std::set<const Mesh*> seen;
    for (const BakedInstance& instance : instances) {
        const bool is_textured = has_textures(instance.surfaces);
        size += (is_textured ? 2 : 1) * sizeof(Rgb) * instance.radiance.size();
        for (const VertexValues& pass : instance.passes)
            size += (pass.is_scalar ? sizeof(float) : sizeof(Rgb)) * pass.values.size();
        if (seen.insert(instance.mesh).second)
            size +=
                (2 * sizeof(Vec3f) + (is_textured ? sizeof(Vec2f) : 0)) * instance.mesh->positions.size() +
                12 * instance.mesh->triangles.size();
    }
    return size;
}

}  // namespace

Result<Done> write_baked_glb(const std::filesystem::path& file, std::span<const BakedInstance> instances) {
    HF_TRY_DONE(check_baked_instances(instances));
    if (instances.empty()) return Error{file.string(), "found no instance; expected at least one"};
    constexpr std::uint64_t room_for_json = std::uint64_t(1) << 28,
                            most = std::numeric_limits<std::uint32_t>::max() - room_for_json;
    const Result<ImageFiles> files = image_files(instances);
    if (!files) return Error{file.string(), files.error().message()};
    const std::uint64_t size = buffer_size(instances, *files);
    if (size > most)
        return Error{file.string(),
                     fmt::format("found {} bytes of vertices, triangles and images; a GLB file can hold {}",
                                 size, most)};

    Buffer buffer;
    buffer.bytes.reserve(size);
    Json nodes = Json::array(), roots = Json::array(), meshes = Json::array();
    std::map<std::pair<const Mesh*, const Surface*>, Json> shared_by_mesh;
    for (const BakedInstance& instance : instances) {
        assert(instance.mesh->normals.size() == instance.mesh->positions.size());
        const auto [shared, is_new] =
            shared_by_mesh.try_emplace(std::pair(instance.mesh, instance.surfaces.data()));
        if (is_new) shared->second = shared_primitives(instance, *files, buffer);
        Json own = Json::object();  // attributes
        std::vector<Rgb> seen, light;
        const std::vector<Rgb> tints = image_tints(instance);
        for (std::size_t v = 0; v < instance.radiance.size(); ++v) {
            seen.push_back(displayed_radiance(instance, v));
            light.push_back(light_at(instance, tints, v));
        }
        own["COLOR_0"] = own["_RADIANCE"] = append_pass({"radiance", seen}, buffer);
        if (has_textures(instance.surfaces)) own["COLOR_0"] = append_pass({"light", light}, buffer);
        for (const VertexValues& pass : instance.passes)
            own[attribute_name(pass.name)] = append_pass(pass, buffer);
        Json primitives = shared->second;
        for (Json& primitive : primitives) primitive["attributes"].update(own);
        nodes.push_back(node_of(instance, meshes.size()));
        roots.push_back(meshes.size());
        meshes.push_back({{"name", instance.name}, {"primitives", std::move(primitives)}});
    }
    Appearance appearance = appearance_of(*files, buffer);
    Json scene{{"asset", {{"version", "2.0"}, {"generator", "haarfield"}}},
               {"extensionsUsed", Json::array({"KHR_materials_unlit"})},
               {"scene", 0},
               {"scenes", Json::array({{{"nodes", std::move(roots)}}})},
               {"nodes", std::move(nodes)},
               {"materials", std::move(appearance.materials)},
               {"meshes", std::move(meshes)},
               {"accessors", std::move(buffer.accessors)},
               {"bufferViews", std::move(buffer.views)},
               {"buffers", Json::array({{{"byteLength", buffer.bytes.size()}}})}};
    if (!files->empty()) {  // glTF forbids empty lists
        scene["textures"] = std::move(appearance.textures);
        scene["images"] = std::move(appearance.images);
    }
    std::string json = scene.dump(-1, ' ', false, Json::error_handler_t::replace);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    if (json.size() > room_for_json) return Error{file.string(), "too many instances for a GLB file"};

    std::string bytes = "glTF";
    append_number(bytes, 2);
    append_number(bytes, 12 + 8 + json.size() + 8 + buffer.bytes.size());
    append_number(bytes, json.size());
    bytes += "JSON" + json;
    append_number(bytes, buffer.bytes.size());
    bytes += std::string_view("BIN\0", 4);
    bytes += buffer.bytes;
    return write_file(file, bytes);
}

}  // namespace haarfield
