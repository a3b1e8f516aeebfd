#include "fields/mesh/mesh_subdivision.h"

#include "fields/mesh/edge_bisection.h"

#include <queue>

namespace haarfield {

namespace {

struct Candidate {
    double length2;  // [m^2]
    std::uint32_t edge;
    bool operator<(const Candidate& other) const {  // the top of the heap is the longest
        return length2 != other.length2 ? length2 < other.length2 : edge > other.edge;
    }
};

}  // namespace

Mesh subdivided(Mesh mesh, std::uint32_t vertices, const Progress& progress) {
    if (mesh.positions.size() >= vertices) return mesh;
    constexpr double same_length2 = 0.998;  // 0.1 % in length
    const std::size_t at_most = vertices + vertices / 10;
    EdgeBisection bisection(std::move(mesh));
    std::priority_queue<Candidate> heap;
    const auto offer = [&](std::uint32_t edge) { heap.push({bisection.squared_length(edge), edge}); };
    for (std::uint32_t edge = 0; edge < bisection.edges().size(); ++edge) offer(edge);
    double last_length2 = INFINITY;
    for (std::size_t splits = 0; !heap.empty(); ++splits) {
        const Candidate longest = heap.top();
        const std::size_t count = bisection.mesh().positions.size();
        if (count >= vertices && (count >= at_most || longest.length2 < same_length2 * last_length2)) break;
        if (splits % 4096 == 0) {
            if (progress.stop.stop_requested()) break;
            if (progress.report) progress.report("subdividing", count, vertices);
        }
        heap.pop();
        const auto first_new = static_cast<std::uint32_t>(bisection.edges().size());
        if (bisection.split(longest.edge)) {
            offer(longest.edge);
            for (std::uint32_t edge = first_new; edge < bisection.edges().size(); ++edge) offer(edge);
        }
        // the class of equal edges is that of the last required split
        if (count < vertices) last_length2 = longest.length2;
    }
    return std::move(bisection).take_mesh();
}

}  // namespace haarfield
