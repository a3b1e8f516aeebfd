#include "fields/mesh/shared_vertices.h"

#include <bit>
#include <cassert>
#include <unordered_map>

namespace haarfield {
namespace {

/// The bits of everything that distinguishes vertices.
struct VertexKey {
    std::array<std::uint32_t, 13> bits{};
    bool operator==(const VertexKey&) const = default;
};

struct VertexKeyHash {
    std::size_t operator()(const VertexKey& key) const {
        std::uint64_t h = 0;
        for (std::uint32_t b : key.bits) {
            h = (h ^ b) * 0x9e3779b97f4a7c15u;
            h ^= h >> 29;
        }
        return h;
    }
};

}  // namespace

Mesh with_shared_vertices(const Mesh& mesh, std::span<const Vec3f> corner_normals,
                          const DistinctAttributes& wanted) {
    assert(wanted.uvs.size() == mesh.material_names.size());
    assert(wanted.colours.size() == mesh.material_names.size());
    const bool has_uvs = wanted.has_uvs(), has_colours = wanted.has_colours(),
               has_numbers = !mesh.original_vertices.empty();
    Mesh shared;
    shared.material_names = mesh.material_names;
    shared.triangles.reserve(mesh.triangles.size());
    std::unordered_map<VertexKey, std::uint32_t, VertexKeyHash> seen;
    seen.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        std::array<std::uint32_t, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = mesh.triangles[t][k];
            const std::uint16_t material = mesh.vertex_materials[vertex];
            const Vec3f p = mesh.positions[vertex] + Vec3f(0, 0, 0),
                        n = corner_normals[3 * t + k] + Vec3f(0, 0, 0);
            const Vec2f uv = wanted.uvs[material] ? mesh.uvs[vertex] + Vec2f(0, 0) : Vec2f(0, 0);
            const Rgb colour = wanted.colours[material] ? mesh.colours[vertex] : Rgb(1.0f);
            VertexKey key;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const int a = static_cast<int>(axis);
                key.bits[axis] = std::bit_cast<std::uint32_t>(p[a]);
                key.bits[3 + axis] = std::bit_cast<std::uint32_t>(n[a]);
                key.bits[9 + axis] = std::bit_cast<std::uint32_t>(colour[a]);
            }
            key.bits[6] = material;
            key.bits[7] = std::bit_cast<std::uint32_t>(uv.x);
            key.bits[8] = std::bit_cast<std::uint32_t>(uv.y);
            if (wanted.originals && has_numbers)
                key.bits[12] = std::bit_cast<std::uint32_t>(mesh.original_vertices[vertex]);
            const auto [found, is_new] =
                seen.try_emplace(key, static_cast<std::uint32_t>(shared.positions.size()));
            if (is_new) {
                shared.positions.push_back(p);
                shared.normals.push_back(n);
                shared.vertex_materials.push_back(material);
                if (has_uvs) shared.uvs.push_back(uv);
                if (has_colours) shared.colours.push_back(colour);
                if (has_numbers) shared.original_vertices.push_back(mesh.original_vertices[vertex]);
            }
            corners[k] = found->second;
        }
        shared.triangles.push_back(corners);
    }
    return shared;
}

Mesh with_shared_vertices(const Mesh& mesh, const DistinctAttributes& wanted) {
    std::vector<Vec3f> normals;
    normals.reserve(3 * mesh.triangles.size());
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle) normals.push_back(mesh.normals[corner]);
    return with_shared_vertices(mesh, normals, wanted);
}

}  // namespace haarfield
