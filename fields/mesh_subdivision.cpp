#include "fields/mesh_subdivision.h"

#include "fields/mesh_topology.h"

#include <algorithm>
#include <queue>
#include <unordered_map>

namespace haarfield {

namespace {

/// The mesh with its edges, an edge being between two positions and not between two vertices.
struct Bisection {
    struct Edge {
        std::array<std::uint32_t, 2> ends;     // places
        std::vector<std::uint32_t> triangles;  // round it, any number
    };
    struct Candidate {
        double length2;  // [m^2]
        std::uint32_t edge;
        bool operator<(const Candidate& other) const {  // the heap's top is the largest
            return length2 != other.length2 ? length2 < other.length2 : edge > other.edge;
        }
    };

    Mesh mesh{};
    std::vector<std::uint32_t> place_of_vertex{};
    std::vector<Vec3f> places{};
    std::vector<Edge> edges{};
    std::vector<std::array<std::uint32_t, 3>> edges_of_triangle{};  // from corner k to k + 1
    std::priority_queue<Candidate> heap{};

    explicit Bisection(Mesh input) : mesh(std::move(input)) {
        MergedPositions merged = merged_positions(mesh.positions);
        place_of_vertex = std::move(merged.index);
        places = std::move(merged.positions);
        std::unordered_map<std::uint64_t, std::uint32_t> known;
        known.reserve(2 * mesh.triangles.size());
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            edges_of_triangle.push_back({});
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t a = place_of_vertex[mesh.triangles[t][k]];
                const std::uint32_t b = place_of_vertex[mesh.triangles[t][(k + 1) % 3]];
                const std::uint64_t key = static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
                const auto [found, is_new] = known.try_emplace(key, static_cast<std::uint32_t>(edges.size()));
                if (is_new) add_edge(a, b);
                edges[found->second].triangles.push_back(t);
                edges_of_triangle[t][k] = found->second;
            }
        }
    }

    std::uint32_t add_edge(std::uint32_t a, std::uint32_t b) {
        edges.push_back({{a, b}, {}});
        const std::uint32_t edge = static_cast<std::uint32_t>(edges.size() - 1);
        offer(edge);
        return edge;
    }

    void offer(std::uint32_t edge) {
        const auto [a, b] = edges[edge].ends;
        heap.push({(Vec3d(places[a]) - Vec3d(places[b])).length2(), edge});
    }

    std::uint32_t add_vertex(std::uint32_t a, std::uint32_t b, std::uint32_t place) {
        mesh.positions.push_back(places[place]);
        const Vec3d sum = Vec3d(mesh.normals[a]) + Vec3d(mesh.normals[b]);
        // opposite normals have no mean
        mesh.normals.push_back(sum.length2() > 1e-12 ? Vec3f(sum.normalized()) : Vec3f(mesh.normals[a]));
        mesh.vertex_materials.push_back(std::uint16_t(mesh.vertex_materials[a]));
        place_of_vertex.push_back(place);
        return static_cast<std::uint32_t>(mesh.positions.size() - 1);
    }

    /// The edge becomes its half at ends[0]; the other half and the cuts to the opposite corners are
    /// new. Does nothing if the middle is one of the ends.
    void split(std::uint32_t edge) {
        const auto [a, b] = edges[edge].ends;
        const Vec3f middle = (places[a] + places[b]) * 0.5f;
        if (middle == places[a] || middle == places[b]) return;
        const std::uint32_t place = static_cast<std::uint32_t>(places.size());
        places.push_back(middle);

        const std::vector<std::uint32_t> round = std::move(edges[edge].triangles);
        edges[edge] = {{a, place}, {}};
        const std::uint32_t other_half = add_edge(place, b);
        offer(edge);

        struct SideVertex {
            std::uint32_t low, high, middle;
        };
        std::vector<SideVertex> side_vertices;  // one per pair of vertices that the seams leave
        std::vector<std::pair<std::uint32_t, std::uint32_t>> cuts;  // opposite place, edge
        for (const std::uint32_t t : round) {
            int k = 0;
            while (edges_of_triangle[t][k] != edge) ++k;
            const std::array<std::uint32_t, 3> corners = mesh.triangles[t], sides = edges_of_triangle[t];
            const std::uint32_t from = corners[k], to = corners[(k + 1) % 3], opposite = corners[(k + 2) % 3];

            const auto [low, high] = std::minmax(from, to);
            auto side = std::find_if(
                side_vertices.begin(), side_vertices.end(),
                [low = low, high = high](const SideVertex& s) { return s.low == low && s.high == high; });
            if (side == side_vertices.end())
                side = side_vertices.insert(side, {low, high, add_vertex(low, high, place)});
            const std::uint32_t vertex = side->middle;

            const std::uint32_t opposite_place = place_of_vertex[opposite];
            auto cut = std::find_if(cuts.begin(), cuts.end(),
                                    [&](const auto& c) { return c.first == opposite_place; });
            if (cut == cuts.end()) cut = cuts.insert(cut, {opposite_place, add_edge(place, opposite_place)});

            const bool from_is_a = place_of_vertex[from] == a;
            const std::uint32_t from_half = from_is_a ? edge : other_half;
            const std::uint32_t to_half = from_is_a ? other_half : edge;
            const std::uint32_t far_side = sides[(k + 1) % 3], near_side = sides[(k + 2) % 3];
            const std::uint32_t fresh = static_cast<std::uint32_t>(mesh.triangles.size());
            mesh.triangles[t] = {from, vertex, opposite};
            edges_of_triangle[t] = {from_half, cut->second, near_side};
            mesh.triangles.push_back({vertex, to, opposite});
            edges_of_triangle.push_back({to_half, far_side, cut->second});
            edges[from_half].triangles.push_back(t);
            edges[to_half].triangles.push_back(fresh);
            edges[cut->second].triangles.insert(edges[cut->second].triangles.end(), {t, fresh});
            std::vector<std::uint32_t>& on_far_side = edges[far_side].triangles;
            *std::find(on_far_side.begin(), on_far_side.end(), t) = fresh;
        }
    }
};

}  // namespace

Mesh subdivided(Mesh mesh, std::uint32_t vertices, const Progress& progress) {
    if (mesh.positions.size() >= vertices) return mesh;
    constexpr double same_length2 = 0.998;  // 0.1 % in length
    const std::size_t at_most = vertices + vertices / 10;
    Bisection bisection(std::move(mesh));
    double last_length2 = INFINITY;
    for (std::size_t splits = 0; !bisection.heap.empty(); ++splits) {
        const Bisection::Candidate longest = bisection.heap.top();
        const std::size_t count = bisection.mesh.positions.size();
        if (count >= vertices && (count >= at_most || longest.length2 < same_length2 * last_length2)) break;
        if (splits % 4096 == 0) {
            if (progress.stop.stop_requested()) break;
            if (progress.report) progress.report("subdividing", count, vertices);
        }
        bisection.heap.pop();
        bisection.split(longest.edge);
        // the class of equal edges is that of the last split that was needed
        if (count < vertices) last_length2 = longest.length2;
    }
    return std::move(bisection.mesh);
}

}  // namespace haarfield
