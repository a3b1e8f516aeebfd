#include "fields/occluder.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <unordered_map>

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

/// Union-find over triangles.
struct Pieces {
    std::vector<std::uint32_t> parent;

    explicit Pieces(std::size_t count) : parent(count) { std::iota(parent.begin(), parent.end(), 0u); }
    std::uint32_t root(std::uint32_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    }
    void join(std::uint32_t i, std::uint32_t j) { parent[root(i)] = root(j); }
};

/// A directed edge of a triangle, sorted so that the uses of one undirected edge lie side by side.
struct EdgeUse {
    std::uint32_t low, high;
    std::uint32_t triangle;
    bool forward;  ///< From low to high.
};

std::vector<EdgeUse> sorted_edge_uses(const std::vector<Triangle>& triangles) {
    std::vector<EdgeUse> uses;
    uses.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3];
            uses.push_back({std::min(from, to), std::max(from, to), t, from < to});
        }
    std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
    });
    return uses;
}

/// Bits of a number below 1024, two places apart.
std::uint32_t spread_bits(std::uint32_t i) {
    i = (i | i << 16) & 0x030000ffu;
    i = (i | i << 8) & 0x0300f00fu;
    i = (i | i << 4) & 0x030c30c3u;
    return (i | i << 2) & 0x09249249u;
}

/// Puts one-sided triangles beside each other that lie close and face alike, so that many groups of 64 are
/// seen wholly from the front or from the back.
void sort_by_facing_and_place(Occluder& occluder) {
    std::vector<std::pair<std::uint64_t, Triangle>> keyed;
    keyed.reserve(occluder.one_sided);
    const Vec3f lower = occluder.bounds.lower;
    const float size = 2 * occluder.bounds.radius(), scale = size > 0 ? 1023 / size : 0;
    for (std::uint32_t i = 0; i < occluder.one_sided; ++i) {
        const Triangle& t = occluder.triangles[i];
        const Vec3f &a = occluder.positions[t[0]], &b = occluder.positions[t[1]],
                    &c = occluder.positions[t[2]];
        const Vec3f normal = (b - a).cross(c - a), place = ((a + b + c) / 3.0f - lower) * scale;
        std::uint64_t facing = 0;
        for (int k = 1; k < 3; ++k)
            if (std::abs(normal[k]) > std::abs(normal[int(facing)])) facing = std::uint64_t(k);
        facing = 2 * facing + (normal[int(facing)] < 0);
        const auto coordinate = [&](float x) {
            return spread_bits(static_cast<std::uint32_t>(std::clamp(x, 0.0f, 1023.0f)));
        };
        keyed.emplace_back(
            facing << 32 | coordinate(place.x) | coordinate(place.y) << 1 | coordinate(place.z) << 2, t);
    }
    std::stable_sort(keyed.begin(), keyed.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::uint32_t i = 0; i < occluder.one_sided; ++i) occluder.triangles[i] = keyed[i].second;
}

}  // namespace

Occluder make_occluder(const Mesh& mesh) {
    Occluder occluder;
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
        while (last < uses.size() && uses[last].low == uses[first].low && uses[last].high == uses[first].high)
            ++last;
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
    sort_by_facing_and_place(occluder);
    prepare_occluder(occluder);
    return occluder;
}

namespace {

OccluderEdges one_sided_edges(const Occluder& occluder) {
    constexpr std::uint32_t cluster_size = 64;
    OccluderEdges found;
    const std::vector<EdgeUse> uses = sorted_edge_uses(
        {occluder.triangles.begin(), occluder.triangles.begin() + std::ptrdiff_t(occluder.one_sided)});
    if (uses.size() % 2 != 0) return found;
    std::vector<OccluderEdge> within, between;
    for (std::size_t i = 0; i < uses.size(); i += 2) {
        const EdgeUse &one = uses[i], &other = uses[i + 1];
        const bool pair = one.low == other.low && one.high == other.high && one.forward != other.forward;
        const bool more = i + 2 < uses.size() && uses[i + 2].low == one.low && uses[i + 2].high == one.high;
        if (!pair || more) return found;
        const OccluderEdge edge{one.low, one.high, one.forward ? one.triangle : other.triangle,
                                one.forward ? other.triangle : one.triangle};
        (edge.forward / cluster_size == edge.backward / cluster_size ? within : between).push_back(edge);
    }
    std::stable_sort(within.begin(), within.end(), [](const OccluderEdge& a, const OccluderEdge& b) {
        return a.forward / cluster_size < b.forward / cluster_size;
    });
    const std::uint32_t clusters = (occluder.one_sided + cluster_size - 1) / cluster_size;
    found.first.assign(clusters + 1, 0);
    for (const OccluderEdge& edge : within) ++found.first[edge.forward / cluster_size + 1];
    std::partial_sum(found.first.begin(), found.first.end(), found.first.begin());
    found.edges = std::move(within);
    found.edges.insert(found.edges.end(), between.begin(), between.end());
    found.clusters.resize(clusters);
    for (std::uint32_t t = 0; t < occluder.one_sided; ++t)
        for (const std::uint32_t v : occluder.triangles[t]) {
            Bounds& box = found.clusters[t / cluster_size];
            for (int k = 0; k < 3; ++k) {
                box.lower[k] = std::min(box.lower[k], occluder.positions[v][k]);
                box.upper[k] = std::max(box.upper[k], occluder.positions[v][k]);
            }
        }
    return found;
}

}  // namespace

void prepare_occluder(Occluder& occluder) {
    constexpr std::size_t widest_vector = 16, word = 64;
    SoaPoints& points = occluder.soa_positions;
    const std::size_t padded_points = occluder.positions.size() + widest_vector;
    for (std::vector<float>* coordinate : {&points.x, &points.y, &points.z})
        coordinate->assign(padded_points, 0.0f);
    for (std::size_t v = 0; v < occluder.positions.size(); ++v) {
        points.x[v] = occluder.positions[v].x;
        points.y[v] = occluder.positions[v].y;
        points.z[v] = occluder.positions[v].z;
    }

    // Relative to the middle, so that offsets keep their digits in a mesh far from the origin.
    occluder.planes_centre = occluder.positions.empty() ? Vec3d(0.0) : Vec3d(occluder.bounds.centre());
    SoaPlanes& planes = occluder.planes;
    const std::size_t padded_planes = (occluder.triangles.size() + word - 1) / word * word;
    for (std::vector<float>* coordinate : {&planes.x, &planes.y, &planes.z, &planes.offset})
        coordinate->assign(padded_planes, 0.0f);
    for (std::size_t t = 0; t < occluder.triangles.size(); ++t) {
        const auto& [i, j, k] = occluder.triangles[t];
        const Vec3d a = Vec3d(occluder.positions[i]) - occluder.planes_centre,
                    b = Vec3d(occluder.positions[j]) - occluder.planes_centre,
                    c = Vec3d(occluder.positions[k]) - occluder.planes_centre;
        const Vec3d normal = (b - a).cross(c - a).normalized();
        planes.x[t] = static_cast<float>(normal.x);
        planes.y[t] = static_cast<float>(normal.y);
        planes.z[t] = static_cast<float>(normal.z);
        // Of the rounded normal, through the middle.
        const Vec3d rounded(planes.x[t], planes.y[t], planes.z[t]);
        planes.offset[t] = static_cast<float>(rounded.dot((a + b + c) / 3.0));
    }
    occluder.one_sided_edges = one_sided_edges(occluder);
}

namespace {

struct Axis {
    int depth, across, up;
};
constexpr std::array<Axis, 3> axes{{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}};

}  // namespace

InsideTest::InsideTest(const Occluder& occluder) : occluder_(occluder) {
    const Vec3f extent = occluder.bounds.upper - occluder.bounds.lower;
    const int cells = std::clamp(static_cast<int>(std::sqrt(double(occluder.one_sided))), 1, 512);
    for (std::size_t a = 0; a < axes.size(); ++a) {
        Grid& grid = grids_[a];
        grid.cells = cells;
        grid.lower = {occluder.bounds.lower[axes[a].across], occluder.bounds.lower[axes[a].up]};
        for (std::size_t k = 0; k < 2; ++k) {
            const float size = extent[k == 0 ? axes[a].across : axes[a].up];
            grid.cells_per_metre[k] = size > 0 ? static_cast<float>(cells) / size : 0.0f;
        }
        // Counting sort of the triangles into all cells that their boxes touch.
        const auto touched = [&](std::uint32_t t, auto&& visit) {
            int low[2] = {cells, cells}, high[2] = {0, 0};
            for (const std::uint32_t v : occluder.triangles[t])
                for (std::size_t k = 0; k < 2; ++k) {
                    const int cell =
                        grid.cell(occluder.positions[v][k == 0 ? axes[a].across : axes[a].up], k);
                    low[k] = std::min(low[k], cell);
                    high[k] = std::max(high[k], cell);
                }
            for (int y = low[1]; y <= high[1]; ++y)
                for (int x = low[0]; x <= high[0]; ++x) visit(static_cast<std::size_t>(y * cells + x));
        };
        grid.first.assign(std::size_t(cells) * std::size_t(cells) + 1, 0);
        for (std::uint32_t t = 0; t < occluder.one_sided; ++t)
            touched(t, [&](std::size_t cell) { ++grid.first[cell + 1]; });
        std::partial_sum(grid.first.begin(), grid.first.end(), grid.first.begin());
        grid.triangle.resize(grid.first.back());
        std::vector<std::uint32_t> next(grid.first.begin(), grid.first.end() - 1);
        for (std::uint32_t t = 0; t < occluder.one_sided; ++t)
            touched(t, [&](std::size_t cell) { grid.triangle[next[cell]++] = t; });
    }
}

int InsideTest::Grid::cell(float coordinate, std::size_t k) const {
    return std::clamp(static_cast<int>((coordinate - lower[k]) * cells_per_metre[k]), 0, cells - 1);
}

bool InsideTest::operator()(const Vec3f& point) const {
    const Bounds& bounds = occluder_.bounds;
    for (int k = 0; k < 3; ++k)
        if (!(point[k] >= bounds.lower[k] && point[k] <= bounds.upper[k])) return false;
    int votes = 0;
    for (std::size_t a = 0; a < axes.size(); ++a) {
        const auto [depth, across, up] = axes[a];
        const Grid& grid = grids_[a];
        // A ray along the axis, shifted by an odd amount so that it misses edges and vertices of axis-aligned
        // parts.
        const double shift = 1.1e-6 * bounds.radius();
        const double px = double(point[across]) + 1.37 * shift, py = double(point[up]) + 0.81 * shift,
                     pz = point[depth];
        const auto cell = static_cast<std::size_t>(grid.cell(static_cast<float>(py), 1) * grid.cells +
                                                   grid.cell(static_cast<float>(px), 0));
        int winding = 0;
        for (std::uint32_t i = grid.first[cell]; i < grid.first[cell + 1]; ++i) {
            const Triangle& t = occluder_.triangles[grid.triangle[i]];
            double x[3], y[3], z[3];
            for (std::size_t k = 0; k < 3; ++k) {
                x[k] = occluder_.positions[t[k]][across] - px;
                y[k] = occluder_.positions[t[k]][up] - py;
                z[k] = occluder_.positions[t[k]][depth] - pz;
            }
            const double w0 = x[1] * y[2] - x[2] * y[1], w1 = x[2] * y[0] - x[0] * y[2],
                         w2 = x[0] * y[1] - x[1] * y[0];
            const bool positive = w0 > 0 && w1 > 0 && w2 > 0, negative = w0 < 0 && w1 < 0 && w2 < 0;
            if (!positive && !negative) continue;
            // Where the ray meets the triangle's plane, times the (signed) area.
            const double distance = (w0 * z[0] + w1 * z[1] + w2 * z[2]) * (positive ? 1 : -1);
            if (distance > 0) winding += positive ? 1 : -1;
        }
        votes += winding > 0;
    }
    return votes >= 2;
}

}  // namespace haarfield
