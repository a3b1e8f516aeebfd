#include "fields/mesh/edge_bisection.h"

#include "fields/mesh/mesh_topology.h"

#include <algorithm>
#include <unordered_map>

namespace haarfield {

EdgeBisection::EdgeBisection(Mesh mesh) : mesh_(std::move(mesh)) {
    MergedPositions merged = merged_positions(mesh_.positions);
    place_of_vertex_ = std::move(merged.index);
    places_ = std::move(merged.positions);
    std::unordered_map<std::uint64_t, std::uint32_t> known;
    known.reserve(2 * mesh_.triangles.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
        edges_of_triangle_.push_back({});
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t a = place_of_vertex_[mesh_.triangles[t][k]];
            const std::uint32_t b = place_of_vertex_[mesh_.triangles[t][(k + 1) % 3]];
            const std::uint64_t key = static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
            const auto [found, is_new] = known.try_emplace(key, static_cast<std::uint32_t>(edges_.size()));
            if (is_new) add_edge(a, b);
            edges_[found->second].triangles.push_back(t);
            edges_of_triangle_[t][k] = found->second;
        }
    }
    cuts_.resize(mesh_.triangles.size());
}

std::uint32_t EdgeBisection::add_edge(std::uint32_t a, std::uint32_t b) {
    edges_.push_back({{a, b}, {}});
    return static_cast<std::uint32_t>(edges_.size() - 1);
}

double EdgeBisection::squared_length(std::uint32_t edge) const {
    const auto [a, b] = edges_[edge].ends;
    return (Vec3d(places_[a]) - Vec3d(places_[b])).length2();
}

Vec3f EdgeBisection::middle(std::uint32_t edge) const {
    const auto [a, b] = edges_[edge].ends;
    return (places_[a] + places_[b]) * 0.5f;
}

std::vector<EdgeBisection::Side> EdgeBisection::sides(std::uint32_t edge) const {
    std::vector<Side> sides;
    for (const std::uint32_t t : edges_[edge].triangles) {
        std::size_t k = 0;
        while (edges_of_triangle_[t][k] != edge) ++k;
        const auto [low, high] = std::minmax(mesh_.triangles[t][k], mesh_.triangles[t][(k + 1) % 3]);
        auto side = std::find_if(sides.begin(), sides.end(), [low = low, high = high](const Side& s) {
            return s.low == low && s.high == high;
        });
        if (side == sides.end()) side = sides.insert(side, {low, high, {}});
        side->triangles.push_back(t);
    }
    return sides;
}

bool EdgeBisection::split(std::uint32_t edge) {
    const auto [a, b] = edges_[edge].ends;
    const Vec3f middle = this->middle(edge);
    if (middle == places_[a] || middle == places_[b]) return false;
    const std::vector<Side> sides = this->sides(edge);
    const std::uint32_t place = static_cast<std::uint32_t>(places_.size());
    places_.push_back(middle);
    const auto first_vertex = static_cast<std::uint32_t>(mesh_.positions.size());
    for (const Side& side : sides) {
        mesh_.positions[add_interpolated_vertex(mesh_, side, 0.5)] = middle;
        place_of_vertex_.push_back(place);
    }

    const std::vector<std::uint32_t> round = std::move(edges_[edge].triangles);
    edges_[edge] = {{a, place}, {}};
    const std::uint32_t other_half = add_edge(place, b);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> cuts;  // opposite place, edge
    for (const std::uint32_t t : round) {
        std::size_t k = 0;
        while (edges_of_triangle_[t][k] != edge) ++k;
        const std::array<std::uint32_t, 3> corners = mesh_.triangles[t], around = edges_of_triangle_[t];
        const std::uint32_t from = corners[k], to = corners[(k + 1) % 3], opposite = corners[(k + 2) % 3];
        const auto side = std::find_if(sides.begin(), sides.end(), [&](const Side& s) {
            return s.low == std::min(from, to) && s.high == std::max(from, to);
        });
        const std::uint32_t vertex = first_vertex + static_cast<std::uint32_t>(side - sides.begin());

        const std::uint32_t opposite_place = place_of_vertex_[opposite];
        auto cut =
            std::find_if(cuts.begin(), cuts.end(), [&](const auto& c) { return c.first == opposite_place; });
        if (cut == cuts.end()) cut = cuts.insert(cut, {opposite_place, add_edge(place, opposite_place)});

        const bool from_is_a = place_of_vertex_[from] == a;
        const std::uint32_t from_half = from_is_a ? edge : other_half;
        const std::uint32_t to_half = from_is_a ? other_half : edge;
        const std::uint32_t far_side = around[(k + 1) % 3], near_side = around[(k + 2) % 3];
        const std::uint32_t fresh = static_cast<std::uint32_t>(mesh_.triangles.size());
        mesh_.triangles[t] = {from, vertex, opposite};
        edges_of_triangle_[t] = {from_half, cut->second, near_side};
        mesh_.triangles.push_back({vertex, to, opposite});
        cuts_[t].push_back({static_cast<std::uint8_t>(k), fresh});
        cuts_.emplace_back();
        edges_of_triangle_.push_back({to_half, far_side, cut->second});
        edges_[from_half].triangles.push_back(t);
        edges_[to_half].triangles.push_back(fresh);
        edges_[cut->second].triangles.insert(edges_[cut->second].triangles.end(), {t, fresh});
        std::vector<std::uint32_t>& on_far_side = edges_[far_side].triangles;
        *std::find(on_far_side.begin(), on_far_side.end(), t) = fresh;
    }
    return true;
}

EdgeBisection::TrianglePoint EdgeBisection::located(TrianglePoint point) const {
    for (std::size_t n = 0; n < cuts_[point.triangle].size(); ++n) {
        const auto [corner, other] = cuts_[point.triangle][n];
        const double from = point.weights[corner], to = point.weights[(corner + 1u) % 3],
                     opposite = point.weights[(corner + 2u) % 3];
        if (from >= to) {
            point.weights = {from - to, 2 * to, opposite};
        } else {
            point = {other, {2 * from, to - from, opposite}};
            n = ~std::size_t(0);  // All splits of the other triangle are later than this one.
        }
    }
    return point;
}

Vec3f interpolated_normal(const Mesh& mesh, const EdgeBisection::Side& side, double share) {
    const Vec3d sum = Vec3d(mesh.normals[side.low]) * (1 - share) + Vec3d(mesh.normals[side.high]) * share;
    // The mean of opposite normals is undefined.
    return sum.length2() > 1e-12 ? Vec3f(sum.normalized()) : mesh.normals[side.low];
}

std::uint32_t add_interpolated_vertex(Mesh& mesh, const EdgeBisection::Side& side, double share) {
    const std::uint32_t vertex = mesh.copy_vertex(side.low);
    const auto high = static_cast<float>(share), low = 1 - high;
    mesh.positions[vertex] =
        Vec3f(Vec3d(mesh.positions[side.low]) * (1 - share) + Vec3d(mesh.positions[side.high]) * share);
    mesh.normals[vertex] = interpolated_normal(mesh, side, share);
    if (!mesh.uvs.empty()) mesh.uvs[vertex] = mesh.uvs[side.low] * low + mesh.uvs[side.high] * high;
    if (!mesh.colours.empty())
        mesh.colours[vertex] = mesh.colours[side.low] * low + mesh.colours[side.high] * high;
    if (!mesh.original_vertices.empty()) mesh.original_vertices[vertex] = not_original;
    return vertex;
}

}  // namespace haarfield
