#include "fields/occluder/occluder.h"

#include <algorithm>
#include <cstring>
#include <unordered_map>

#include "fields/mesh/closed_pieces.h"

namespace haarfield {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

struct PositionHash {
    std::size_t operator()(const Vec3f& p) const {
        std::uint32_t bits[3];
        std::memcpy(bits, &p, sizeof bits);
        return (std::size_t(bits[0]) * 0x9e3779b97f4a7c15u) ^ (std::size_t(bits[1]) * 0xc2b2ae3d27d4eb4fu) ^
               (std::size_t(bits[2]) * 0x165667b19e3779f9u);
    }
};

}  // namespace

OccluderTriangles occluder_triangles(const Mesh& mesh) {
    OccluderTriangles occluder;
    std::unordered_map<Vec3f, std::uint32_t, PositionHash> index_of;
    std::vector<std::uint32_t> merged(mesh.positions.size());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3f p = mesh.positions[v] + Vec3f(0.0f);  // -0 becomes +0
        const auto [entry, is_new] =
            index_of.emplace(p, static_cast<std::uint32_t>(occluder.positions.size()));
        if (is_new) occluder.positions.push_back(p);
        merged[v] = entry->second;
    }
    std::vector<Triangle> triangles;
    for (const Triangle& t : mesh.triangles) {
        const Triangle m{merged[t[0]], merged[t[1]], merged[t[2]]};
        if (m[0] != m[1] && m[1] != m[2] && m[2] != m[0]) triangles.push_back(m);
    }
    occluder.bounds = mesh_bounds(mesh);

    const std::vector<PieceKind> kinds = piece_kinds(occluder.positions, triangles);
    for (const bool wanted : {true, false}) {
        for (std::uint32_t t = 0; t < triangles.size(); ++t)
            if ((kinds[t] == PieceKind::solid) == wanted) occluder.triangles.push_back(triangles[t]);
        if (wanted) occluder.one_sided = static_cast<std::uint32_t>(occluder.triangles.size());
    }
    return occluder;
}

Occluder make_occluder(const Mesh& mesh) {
    return Occluder(occluder_triangles(mesh));
}

Occluder turned_occluder(const Occluder& occluder, const Rotation& rotation) {
    OccluderTriangles turned = occluder.source();
    for (Vec3f& position : turned.positions) position = rotation(position);
    turned.bounds = bounds_of(turned.positions);
    return Occluder(std::move(turned));
}

}  // namespace haarfield
