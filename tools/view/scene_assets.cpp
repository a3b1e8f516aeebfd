#include "tools/view/scene_assets.h"

#include "tools/view/message_writer.h"
#include "tools/view/messages.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace haarfield {
namespace {

void append_halves(std::string& bytes, const std::vector<std::uint16_t>& halves) {
    bytes.append(reinterpret_cast<const char*>(halves.data()), halves.size() * sizeof(std::uint16_t));
    if (halves.size() % 2 != 0) bytes.append(2, '\0');
}

/// Returns a triangle's material, as the preview does.
std::size_t material_of(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
    return mesh.vertex_materials[triangle[0]];
}

}  // namespace

std::string mesh_bytes(const Mesh& mesh) {
    std::vector<std::vector<std::array<std::uint32_t, 3>>> by_material(mesh.material_names.size());
    for (const auto& triangle : mesh.triangles) by_material[material_of(mesh, triangle)].push_back(triangle);
    std::string bytes;
    for (const std::size_t number :
         {mesh.positions.size(), mesh.triangles.size(), std::size_t(!mesh.uvs.empty()), by_material.size()})
        append(bytes, static_cast<std::uint32_t>(number));
    std::uint32_t first = 0;
    for (const auto& triangles : by_material) {
        append(bytes, first);
        first += static_cast<std::uint32_t>(triangles.size());
    }
    for (const Vec3f& position : mesh.positions)
        for (int axis = 0; axis < 3; ++axis) append(bytes, position[axis]);
    for (const Vec2f& uv : mesh.uvs)
        for (int axis = 0; axis < 2; ++axis) append(bytes, uv[axis]);
    for (const auto& triangles : by_material)
        bytes.append(reinterpret_cast<const char*>(triangles.data()),
                     triangles.size() * sizeof(triangles.front()));
    return bytes;
}

nlohmann::json part_materials(const SceneEntity& entity, const Entity& description) {
    nlohmann::json names = nlohmann::json::array();
    for (const std::string& name : entity.mesh.fine.material_names) {
        const auto named = description.materials.find(name);
        const std::string& material =
            named != description.materials.end() ? named->second : description.material;
        names.push_back(material.empty() ? nlohmann::json() : nlohmann::json(material));
    }
    return names;
}

nlohmann::json json_of(const SceneEntity& entity, std::size_t number, const Entity& description) {
    nlohmann::json parts = nlohmann::json::array();
    const nlohmann::json materials = part_materials(entity, description);
    for (std::size_t m = 0; m < entity.surfaces.size(); ++m) {
        const std::string& name = entity.mesh.fine.material_names[m];
        nlohmann::json part{{"name", name}};
        part["material"] = materials[m];
        const std::shared_ptr<const Texture>& texture = entity.surfaces[m].texture;
        part["texture"] =
            texture ? nlohmann::json(fmt::format("texture/{}/{}", number, m)) : nlohmann::json();
        part["cut_out"] = texture && texture->has_alpha;
        parts.push_back(std::move(part));
    }
    return {{"name", entity.name},
            {"mesh", fmt::format("mesh/{}", number)},
            {"vertices", entity.mesh.fine.positions.size()},
            {"triangles", entity.mesh.fine.triangles.size()},
            {"parts", std::move(parts)}};
}

std::string frame_bytes(const FrameHead& head, const Design& design,
                        const std::map<std::uint32_t, VertexColours>& colours) {
    std::size_t count = 0, size = 24;
    for (const std::uint32_t id : design.ids)
        if (const auto known = colours.find(id); known != colours.end()) {
            ++count;
            size += 16 + 2 * (known->second.textured.size() + known->second.added.size());
        }
    std::string bytes("HFF1");
    bytes.reserve(size);
    append(bytes, head.frame);
    append(bytes, head.message);
    append(bytes, static_cast<std::uint32_t>(head.exactness));
    append(bytes, head.milliseconds);
    append(bytes, static_cast<std::uint32_t>(count));
    for (const std::uint32_t id : design.ids) {
        const auto known = colours.find(id);
        if (known == colours.end()) continue;
        append(bytes, id);
        append(bytes, static_cast<std::uint32_t>(known->second.textured.size() / 3));
        append(bytes, std::uint32_t(!known->second.added.empty()));
        append_halves(bytes, known->second.textured);
        append_halves(bytes, known->second.added);
    }
    return bytes;
}

}  // namespace haarfield
