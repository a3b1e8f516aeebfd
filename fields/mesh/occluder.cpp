#include "fields/mesh/occluder.h"

#include <algorithm>
#include <cstring>
#include <unordered_map>

#include "fields/mesh/edge_uses.h"

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

Occluder make_occluder(const Mesh& mesh) {
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

    Pieces pieces(triangles.size());
    const std::vector<EdgeUse> uses = sorted_edge_uses(triangles);
    std::vector<std::uint8_t> open_at(triangles.size(), 0);
    for (std::size_t first = 0; first < uses.size();) {
        std::size_t last = first;
        while (last < uses.size() && same_edge(uses[first], uses[last])) ++last;
        const bool closed = last - first == 2 && uses[first].forward != uses[first + 1].forward;
        for (std::size_t i = first; i < last; ++i) {
            pieces.join(uses[i].triangle, uses[first].triangle);
            if (!closed) open_at[uses[i].triangle] = 1;
        }
        first = last;
    }
    std::vector<std::uint8_t> open(triangles.size(), 0);
    std::vector<double> volume(triangles.size(), 0);
    const Vec3d centre(occluder.bounds.centre());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const std::uint32_t root = pieces.root(t);
        open[root] |= open_at[t];
        const Vec3d a = Vec3d(occluder.positions[triangles[t][0]]) - centre,
                    b = Vec3d(occluder.positions[triangles[t][1]]) - centre,
                    c = Vec3d(occluder.positions[triangles[t][2]]) - centre;
        volume[root] += a.dot(b.cross(c));
    }
    const auto is_one_sided = [&](std::uint32_t t) {
        const std::uint32_t root = pieces.root(t);
        return !open[root] && volume[root] > 0;
    };
    for (const bool wanted : {true, false}) {
        for (std::uint32_t t = 0; t < triangles.size(); ++t)
            if (is_one_sided(t) == wanted) occluder.triangles.push_back(triangles[t]);
        if (wanted) occluder.one_sided = static_cast<std::uint32_t>(occluder.triangles.size());
    }
    return Occluder(std::move(occluder));
}

Occluder turned_occluder(const Occluder& occluder, const Rotation& rotation) {
    OccluderTriangles turned = occluder.source();
    for (Vec3f& position : turned.positions) position = rotation(position);
    turned.bounds = bounds_of(turned.positions);
    return Occluder(std::move(turned));
}

}  // namespace haarfield
