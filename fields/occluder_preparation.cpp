#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fields/edge_uses.h"
#include "fields/occluder.h"

namespace haarfield {
namespace {

constexpr std::uint32_t cluster_size = 64;

void fill_points(Occluder& occluder) {
    constexpr std::size_t widest_vector = 16;
    SoaPoints& points = occluder.soa_positions;
    const std::size_t padded = occluder.positions.size() + widest_vector;
    for (std::vector<float>* coordinate : {&points.x, &points.y, &points.z}) coordinate->assign(padded, 0.0f);
    for (std::size_t v = 0; v < occluder.positions.size(); ++v) {
        points.x[v] = occluder.positions[v].x;
        points.y[v] = occluder.positions[v].y;
        points.z[v] = occluder.positions[v].z;
    }
}

void fill_planes(Occluder& occluder) {
    // Relative to the middle, so that offsets keep their digits in a mesh far from the origin.
    occluder.planes_centre = occluder.positions.empty() ? Vec3d(0.0) : Vec3d(occluder.bounds.centre());
    SoaPlanes& planes = occluder.planes;
    const std::size_t padded = (occluder.triangles.size() + cluster_size - 1) / cluster_size * cluster_size;
    for (std::vector<float>* coordinate : {&planes.x, &planes.y, &planes.z}) coordinate->assign(padded, 0.0f);
    planes.offset.assign(padded, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t t = 0; t < occluder.triangles.size(); ++t) {
        const auto& [i, j, k] = occluder.triangles[t];
        const Vec3d a = Vec3d(occluder.positions[i]) - occluder.planes_centre,
                    b = Vec3d(occluder.positions[j]) - occluder.planes_centre,
                    c = Vec3d(occluder.positions[k]) - occluder.planes_centre;
        const double longest = std::max({(b - a).length(), (c - b).length(), (a - c).length()});
        const Vec3d normal = (b - a).cross(c - a) / longest;
        // Of the rounded normal, through the middle.
        const Vec3d rounded = Vec3d(Vec3f(normal));
        if (!(rounded.length() > 0)) continue;
        planes.x[t] = static_cast<float>(rounded.x);
        planes.y[t] = static_cast<float>(rounded.y);
        planes.z[t] = static_cast<float>(rounded.z);
        planes.offset[t] = static_cast<float>(rounded.dot((a + b + c) / 3.0));
    }
}

struct Edge {
    EdgeEnds ends;
    EdgeSides sides;
};

/// Edges with one triangle on each side as far as possible. `lone` counts, by piece, the others.
std::vector<Edge> matched_edges(const std::vector<EdgeUse>& uses, std::uint32_t none, Pieces& pieces,
                                std::vector<std::uint32_t>& lone) {
    std::vector<Edge> edges;
    for (std::size_t first = 0, last; first < uses.size(); first = last) {
        std::vector<std::uint32_t> forward, backward;
        for (last = first; last < uses.size() && same_edge(uses[first], uses[last]); ++last)
            (uses[last].forward ? forward : backward).push_back(uses[last].triangle);
        for (std::size_t i = 0; i < std::max(forward.size(), backward.size()); ++i) {
            const EdgeSides sides{i < forward.size() ? forward[i] : none,
                                  i < backward.size() ? backward[i] : none};
            if (sides.forward == none || sides.backward == none)
                ++lone[pieces.root(std::min(sides.forward, sides.backward))];
            edges.push_back({{uses[first].low, uses[first].high}, sides});
        }
    }
    return edges;
}

OccluderEdges contour_edges(const Occluder& occluder) {
    const auto count = static_cast<std::uint32_t>(occluder.triangles.size());
    const std::vector<EdgeUse> uses = sorted_edge_uses(occluder.triangles);
    Pieces pieces(count);
    for (std::size_t i = 1; i < uses.size(); ++i)
        if (same_edge(uses[i - 1], uses[i])) pieces.join(uses[i].triangle, uses[i - 1].triangle);
    std::vector<std::uint32_t> lone(count, 0), size(count, 0);
    std::vector<Edge> all = matched_edges(uses, count, pieces, lone);
    for (std::uint32_t t = 0; t < count; ++t) ++size[pieces.root(t)];

    // A lone edge is always drawn, and costs as much as half a triangle.
    const auto is_loose = [&](std::uint32_t t) { return 2 * lone[pieces.root(t)] > size[pieces.root(t)]; };
    const auto lower = [](const Edge& e) { return std::min(e.sides.forward, e.sides.backward); };
    std::erase_if(all, [&](const Edge& e) { return is_loose(lower(e)); });
    const std::uint32_t clusters = (count + cluster_size - 1) / cluster_size;
    // The numbers of clusters, or one past the last of them for edges between two.
    const auto cluster = [&](const Edge& e) {
        const std::uint32_t c = e.sides.forward / cluster_size;
        return c == e.sides.backward / cluster_size ? c : clusters;
    };
    std::stable_sort(all.begin(), all.end(), [&](const Edge& a, const Edge& b) {
        return cluster(a) != cluster(b) ? cluster(a) < cluster(b) : lower(a) < lower(b);
    });
    OccluderEdges found;
    found.first.assign(clusters + 2, 0);
    for (const Edge& edge : all) {
        found.ends.push_back(edge.ends);
        found.sides.push_back(edge.sides);
        ++found.first[cluster(edge) + 1];
    }
    std::partial_sum(found.first.begin(), found.first.end(), found.first.begin());
    found.first.pop_back();
    found.loose.assign(clusters, 0);
    for (std::uint32_t t = 0; t < count; ++t)
        found.loose[t / cluster_size] |= std::uint64_t(is_loose(t)) << (t % cluster_size);
    return found;
}

AxisGrid axis_grid(const Occluder& occluder, const AxisFrame& frame) {
    const Vec3f extent = occluder.bounds.upper - occluder.bounds.lower;
    const int cells = std::clamp(static_cast<int>(std::sqrt(double(occluder.triangles.size()))), 1, 512);
    AxisGrid grid;
    grid.cells = cells;
    grid.lower = {occluder.bounds.lower[frame.across], occluder.bounds.lower[frame.up]};
    for (std::size_t k = 0; k < 2; ++k) {
        const float size = extent[k == 0 ? frame.across : frame.up];
        grid.cells_per_metre[k] = size > 0 ? static_cast<float>(cells) / size : 0.0f;
    }
    // Counting sort of the triangles into all cells that their boxes touch.
    const auto touched = [&](std::uint32_t t, auto&& visit) {
        int low[2] = {cells, cells}, high[2] = {0, 0};
        for (const std::uint32_t v : occluder.triangles[t])
            for (std::size_t k = 0; k < 2; ++k) {
                const int cell = grid.cell(occluder.positions[v][k == 0 ? frame.across : frame.up], k);
                low[k] = std::min(low[k], cell);
                high[k] = std::max(high[k], cell);
            }
        for (int y = low[1]; y <= high[1]; ++y)
            for (int x = low[0]; x <= high[0]; ++x) visit(static_cast<std::size_t>(y * cells + x));
    };
    const auto count = static_cast<std::uint32_t>(occluder.triangles.size());
    grid.first.assign(std::size_t(cells) * std::size_t(cells) + 1, 0);
    for (std::uint32_t t = 0; t < count; ++t) touched(t, [&](std::size_t cell) { ++grid.first[cell + 1]; });
    std::partial_sum(grid.first.begin(), grid.first.end(), grid.first.begin());
    grid.triangle.resize(grid.first.back());
    std::vector<std::uint32_t> next(grid.first.begin(), grid.first.end() - 1);
    for (std::uint32_t t = 0; t < count; ++t)
        touched(t, [&](std::size_t cell) { grid.triangle[next[cell]++] = t; });
    return grid;
}

}  // namespace

int AxisGrid::cell(float coordinate, std::size_t k) const {
    return static_cast<int>(
        std::clamp((coordinate - lower[k]) * cells_per_metre[k], 0.0f, static_cast<float>(cells - 1)));
}

std::span<const std::uint32_t> AxisGrid::triangles_at(float across, float up) const {
    const auto at = static_cast<std::size_t>(cell(up, 1) * cells + cell(across, 0));
    return {triangle.data() + first[at], first[at + 1] - first[at]};
}

void prepare_occluder(Occluder& occluder) {
    fill_points(occluder);
    fill_planes(occluder);
    occluder.contour_edges = contour_edges(occluder);
    for (std::size_t axis = 0; axis < 3; ++axis)
        occluder.grids[axis] = axis_grid(occluder, axis_frames[axis]);
}

}  // namespace haarfield
