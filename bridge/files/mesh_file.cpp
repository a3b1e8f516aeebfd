#include "bridge/files/mesh_file.h"

#include "bridge/files/glb_file.h"
#include "fields/file/write_file.h"
#include "scenes/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace haarfield {
namespace {

template <class T>
void append_bytes(std::string& text, T value) {
    static_assert(std::endian::native == std::endian::little);  // as the file's header states
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    text.append(bytes, sizeof(T));
}

/// Returns a CSV field, quoted as RFC 4180 specifies.
std::string csv_text(const std::string& text) {
    if (text.find_first_of("\",\r\n") == text.npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

/// Returns the column names of the instances' passes.
std::vector<std::string> pass_columns(std::span<const BakedInstance> instances) {
    std::vector<std::string> names;
    if (instances.empty()) return names;
    for (const VertexValues& pass : instances.front().passes)
        if (pass.is_scalar)
            names.push_back(pass.name);
        else
            for (const char* channel : {"_r", "_g", "_b"}) names.push_back(pass.name + channel);
    return names;
}

/// Calls act(number) for each number of a vertex's passes, in the order of the columns.
template <class Act>
void for_each_pass_number(const BakedInstance& instance, std::size_t vertex, const Act& act) {
    for (const VertexValues& pass : instance.passes)
        for (int c = 0; c < (pass.is_scalar ? 1 : 3); ++c) act(pass.values[vertex][c]);
}

}  // namespace

Result<Done> write_baked_ply(const std::filesystem::path& file, std::span<const BakedInstance> instances) {
    HF_TRY_DONE(check_baked_instances(instances));
    std::uint64_t vertices = 0, faces = 0, corners = 0;
    std::uint32_t most_corners = 3;
    for (const BakedInstance& instance : instances) {
        assert(instance.mesh->normals.size() == instance.mesh->positions.size());
        vertices += instance.mesh->positions.size();
        const ListedMesh* const listed = instance.listed;
        assert(!listed || listed->positions.size() == instance.mesh->positions.size());
        faces += listed ? listed->face_corners.size() : instance.mesh->triangles.size();
        corners += listed ? listed->corners.size() : 3 * instance.mesh->triangles.size();
        if (listed && !listed->face_corners.empty())
            most_corners = std::max(most_corners, std::ranges::max(listed->face_corners));
    }
    if (vertices >= std::uint64_t{1} << 31)
        return Error{file.string(), fmt::format("found {} vertices; expected fewer than 2^31", vertices)};

    const std::vector<std::string> columns = pass_columns(instances);
    const bool has_bytes = most_corners <= 255;
    std::string pass_properties;
    for (const std::string& column : columns) pass_properties += "property float " + column + "\n";
    std::string text = fmt::format(
        "ply\nformat binary_little_endian 1.0\n"
        "comment baked by haarfield; radiance is linear, red green blue its sRGB encoding\n"
        "element vertex {}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property float radiance_r\nproperty float radiance_g\nproperty float radiance_b\n"
        "property int instance\nproperty int original_vertex\n"
        "{}"
        "element face {}\nproperty list {} int vertex_indices\nend_header\n",
        vertices, pass_properties, faces, has_bytes ? "uchar" : "int");
    text.reserve(text.size() + (47 + sizeof(float) * columns.size()) * vertices +
                 (has_bytes ? 1 : 4) * faces + 4 * corners);
    std::int32_t number = 0;
    for (const BakedInstance& instance : instances) {
        const std::vector<std::int32_t>& original = instance.mesh->original_vertices;
        for (std::size_t i = 0; i < instance.mesh->positions.size(); ++i) {
            const Vec3f position = instance.placement.point_to_world(instance.mesh->positions[i]);
            for (int axis = 0; axis < 3; ++axis) append_bytes(text, position[axis]);
            const Vec3f normal = instance.placement.direction_to_world(instance.mesh->normals[i]);
            for (int axis = 0; axis < 3; ++axis) append_bytes(text, normal[axis]);
            const Rgb radiance = displayed_radiance(instance, i);
            for (int c = 0; c < 3; ++c) append_bytes(text, unit_byte(srgb_encoded(radiance[c])));
            for (int c = 0; c < 3; ++c) append_bytes(text, radiance[c]);
            append_bytes(text, number);
            append_bytes(text, original.empty() ? not_original : original[i]);
            for_each_pass_number(instance, i, [&](float value) { append_bytes(text, value); });
        }
        ++number;
    }
    std::int32_t first = 0;
    for (const BakedInstance& instance : instances) {
        const auto append_face = [&](std::span<const std::uint32_t> of) {
            if (has_bytes)
                append_bytes(text, static_cast<std::uint8_t>(of.size()));
            else
                append_bytes(text, static_cast<std::int32_t>(of.size()));
            for (const std::uint32_t index : of) append_bytes(text, first + static_cast<std::int32_t>(index));
        };
        if (instance.listed) {
            std::span<const std::uint32_t> left = instance.listed->corners;
            for (const std::uint32_t count : instance.listed->face_corners) {
                append_face(left.first(count));
                left = left.subspan(count);
            }
        } else {
            for (const auto& triangle : instance.mesh->triangles) append_face(triangle);
        }
        first += static_cast<std::int32_t>(instance.mesh->positions.size());
    }
    return write_file(file, text);
}

Result<Done> write_baked_csv(const std::filesystem::path& file, std::span<const BakedInstance> instances) {
    HF_TRY_DONE(check_baked_instances(instances));
    std::string text = "instance,vertex,x,y,z,nx,ny,nz,radiance_r,radiance_g,radiance_b";
    for (const std::string& column : pass_columns(instances)) text += "," + column;
    text += '\n';
    auto out = std::back_inserter(text);
    for (const BakedInstance& instance : instances) {
        assert(instance.mesh->normals.size() == instance.mesh->positions.size());
        const std::string name = csv_text(instance.name);
        for (std::size_t i = 0; i < instance.mesh->positions.size(); ++i) {
            const Vec3f p = instance.placement.point_to_world(instance.mesh->positions[i]),
                        n = instance.placement.direction_to_world(instance.mesh->normals[i]);
            const Rgb c = displayed_radiance(instance, i);
            fmt::format_to(out, "{},{},{},{},{},{},{},{},{},{},{}", name, i, p.x, p.y, p.z, n.x, n.y, n.z,
                           c.x, c.y, c.z);
            for_each_pass_number(instance, i, [&](float value) { fmt::format_to(out, ",{}", value); });
            text += '\n';
        }
    }
    return write_file(file, text);
}

std::span<const MeshFormat> mesh_formats() {
    static constexpr std::array formats{
        MeshFormat{"ply", "all instances in world space, with normals and passes", write_baked_ply},
        MeshFormat{"glb", "glTF with images and linear radiance as COLOR_0", write_baked_glb, true},
        MeshFormat{"csv", "a table of all vertices in world space", write_baked_csv}};
    return formats;
}

}  // namespace haarfield
