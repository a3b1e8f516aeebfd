#include "bridge/glb_file.h"

#include "fields/file/write_file.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace haarfield {
namespace {

static_assert(std::endian::native == std::endian::little);  // as glTF is

using Json = nlohmann::ordered_json;

constexpr int float_components = 5126, index_components = 5125;  // glTF's numbers for GL's
constexpr int vertex_target = 34962, index_target = 34963;

/// The binary chunk, and what is said of it.
struct Buffer {
    std::string bytes;
    Json views = Json::array(), accessors = Json::array();

    /// Appends items without padding; all are multiples of four bytes. Returns their accessor.
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
};

Json json_of(const Vec3f& v) {
    return {v.x, v.y, v.z};
}

/// What instances of one mesh share.
Json shared_primitive(const Mesh& mesh, Buffer& buffer) {
    const std::size_t positions = buffer.append_vectors(mesh.positions);
    const Bounds bounds = mesh_bounds(mesh);
    buffer.accessors[positions]["min"] = json_of(bounds.lower);
    buffer.accessors[positions]["max"] = json_of(bounds.upper);
    const std::size_t normals = buffer.append_vectors(mesh.normals);
    const std::size_t indices = buffer.append(
        std::span(mesh.triangles), index_target,
        {{"componentType", index_components}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}});
    return {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
            {"indices", indices},
            {"material", 0}};
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

/// `_NAME`, as glTF calls what an application adds.
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

/// Bytes that the buffer takes.
std::uint64_t buffer_size(std::span<const BakedInstance> instances) {
    std::uint64_t size = 0;
    std::set<const Mesh*> seen;
    for (const BakedInstance& instance : instances) {
        size += sizeof(Rgb) * instance.radiance.size();
        for (const VertexValues& pass : instance.passes)
            size += (pass.is_scalar ? sizeof(float) : sizeof(Rgb)) * pass.values.size();
        if (seen.insert(instance.mesh).second)
            size +=
                2 * sizeof(Vec3f) * instance.mesh->positions.size() + 12 * instance.mesh->triangles.size();
    }
    return size;
}

}  // namespace

Result<Done> write_baked_glb(const std::filesystem::path& file, std::span<const BakedInstance> instances) {
    if (Result<Done> good = check_baked_instances(instances); !good) return good.error();
    if (instances.empty()) return Error{file.string(), "there is no instance; wanted at least one"};
    constexpr std::uint64_t room_for_json = std::uint64_t(1) << 28,
                            most = std::numeric_limits<std::uint32_t>::max() - room_for_json;
    const std::uint64_t size = buffer_size(instances);
    if (size > most)
        return Error{file.string(),
                     fmt::format("{} bytes of vertices and triangles; a GLB file holds {}", size, most)};

    Buffer buffer;
    buffer.bytes.reserve(size);
    Json nodes = Json::array(), roots = Json::array(), meshes = Json::array();
    std::map<const Mesh*, Json> primitives;
    for (const BakedInstance& instance : instances) {
        assert(instance.mesh->normals.size() == instance.mesh->positions.size());
        const auto [shared, is_new] = primitives.try_emplace(instance.mesh);
        if (is_new) shared->second = shared_primitive(*instance.mesh, buffer);
        Json primitive = shared->second;
        std::vector<Rgb> seen;
        for (std::size_t v = 0; v < instance.radiance.size(); ++v) seen.push_back(seen_at(instance, v));
        const std::size_t colours = append_pass({"radiance", seen}, buffer);
        primitive["attributes"]["COLOR_0"] = primitive["attributes"]["_RADIANCE"] = colours;
        for (const VertexValues& pass : instance.passes)
            primitive["attributes"][attribute_name(pass.name)] = append_pass(pass, buffer);
        nodes.push_back(node_of(instance, meshes.size()));
        roots.push_back(meshes.size());
        meshes.push_back({{"name", instance.name}, {"primitives", Json::array({std::move(primitive)})}});
    }
    const Json material{{"name", "baked radiance"},
                        {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                        {"extensions", {{"KHR_materials_unlit", Json::object()}}}};
    const Json scene{{"asset", {{"version", "2.0"}, {"generator", "haarfield"}}},
                     {"extensionsUsed", Json::array({"KHR_materials_unlit"})},
                     {"scene", 0},
                     {"scenes", Json::array({{{"nodes", std::move(roots)}}})},
                     {"nodes", std::move(nodes)},
                     {"materials", Json::array({material})},
                     {"meshes", std::move(meshes)},
                     {"accessors", std::move(buffer.accessors)},
                     {"bufferViews", std::move(buffer.views)},
                     {"buffers", Json::array({{{"byteLength", buffer.bytes.size()}}})}};
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
