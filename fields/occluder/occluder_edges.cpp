#include "fields/occluder/occluder_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "fields/base/aligned_buffer.h"
#include "fields/mesh/edge_uses.h"
#include "fields/occluder/occluder.h"

namespace haarfield {
namespace {

constexpr float nan_offset = std::numeric_limits<float>::quiet_NaN();

/// The triangles that edges are built from.
struct PlanedTriangles {
    const OccluderTriangles& source;
    const OccluderPlanes& planes;
};

struct Edge {
    std::array<std::uint32_t, 2> ends;
    std::array<std::uint32_t, 2> triangles;  ///< Left and right, as in OccluderEdges::Cluster.
};

/// Forms edges with one triangle on each side where possible. Counts all others in `lone`, by piece.
std::vector<Edge> matched_edges(const std::vector<EdgeUse>& uses, std::uint32_t none, Pieces& pieces,
                                std::vector<std::uint32_t>& lone) {
    std::vector<Edge> edges;
    for (std::size_t first = 0, last; first < uses.size(); first = last) {
        std::vector<std::uint32_t> forward, backward;
        for (last = first; last < uses.size() && same_edge(uses[first], uses[last]); ++last)
            (uses[last].forward ? forward : backward).push_back(uses[last].triangle);
        for (std::size_t i = 0; i < std::max(forward.size(), backward.size()); ++i) {
            const std::array<std::uint32_t, 2> triangles{i < forward.size() ? forward[i] : none,
                                                         i < backward.size() ? backward[i] : none};
            if (triangles[0] == none || triangles[1] == none)
                ++lone[pieces.root(std::min(triangles[0], triangles[1]))];
            edges.push_back({{uses[first].low, uses[first].high}, triangles});
        }
    }
    return edges;
}

/// A triangle's plane as a point of the dual space: unit normal and offset. NaN for zero area.
using DualPoint = std::array<double, 4>;

DualPoint dual_point(const OccluderPlanes& planes, std::size_t t) {
    const Vec3d normal(planes.x[t], planes.y[t], planes.z[t]);
    const double length = normal.length();
    return {normal.x / length, normal.y / length, normal.z / length, double(planes.offset[t]) / length};
}

/// The position of an edge for sorting: its planes and its midpoint, with lengths in radii, and padding. The
/// size suits vectors.
struct alignas(64) EdgePlace {
    static constexpr std::size_t dimensions = 11;
    std::array<float, 16> at{};
};

/// Sorts edges into clusters. Each coordinate has a list of all edges in its order, and a range of edges is
/// at the same place in all lists.
class ClusterSort {
public:
    explicit ClusterSort(const std::vector<EdgePlace>& places)
        : places_(places), is_first_(places.size()), rest_(places.size()) {
        for (std::size_t k = 0; k < lists_.size(); ++k) {
            lists_[k].resize(places.size());
            std::iota(lists_[k].begin(), lists_[k].end(), 0u);
            std::ranges::stable_sort(lists_[k], {}, [&](std::uint32_t edge) { return places[edge].at[k]; });
        }
        sort(0, places.size());
    }

    /// Returns indices of edges, cluster by cluster.
    const std::vector<std::uint32_t>& order() const { return lists_[0]; }

private:
    using Indices = std::span<const std::uint32_t>;

    /// Divides edges recursively down to clusters, each time in the way that makes the halves most compact.
    void sort(std::size_t begin, std::size_t end) {
        const std::size_t cluster = OccluderEdges::cluster_size, count = end - begin,
                          half = (count / cluster + 1) / 2 * cluster;
        if (count <= cluster) return;
        std::size_t best = 0;
        float least = INFINITY;
        for (std::size_t k = 0; k < lists_.size(); ++k) {
            const Indices edges(&lists_[k][begin], count);
            const float likelihood = cut_likelihood(edges.first(half)) + cut_likelihood(edges.subspan(half));
            if (likelihood < least) {
                least = likelihood;
                best = k;
            }
        }
        for (std::size_t i = 0; i < count; ++i) is_first_[lists_[best][begin + i]] = i < half;
        for (std::size_t k = 0; k < lists_.size(); ++k)
            if (k != best) part(&lists_[k][begin], count);
        sort(begin, begin + half);
        sort(begin + half, end);
    }

    /// Moves the edges of the first half to the front. Keeps the order within each half.
    void part(std::uint32_t* edges, std::size_t count) {
        std::size_t first = 0, rest = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t edge = edges[i];
            edges[first] = rest_[rest] = edge;
            first += is_first_[edge];
            rest += 1u - is_first_[edge];
        }
        std::copy_n(rest_.begin(), rest, edges + first);
    }

    /// Returns the likelihood, up to a factor, that a view point's plane or a horizon cuts a cluster of these
    /// edges.
    float cut_likelihood(Indices edges) const {
        std::array<float, 16> low = places_[edges[0]].at, high = low;
        for (const std::uint32_t edge : edges) {
            const std::array<float, 16>& at = places_[edge].at;
            for (std::size_t k = 0; k < at.size(); ++k) {
                low[k] = std::min(low[k], at[k]);
                high[k] = std::max(high[k], at[k]);
            }
        }
        float sum = 0;
        for (std::size_t k = 0; k < EdgePlace::dimensions; ++k) sum += high[k] - low[k];
        return sum;
    }

    const std::vector<EdgePlace>& places_;
    std::array<std::vector<std::uint32_t>, EdgePlace::dimensions> lists_;
    std::vector<std::uint8_t> is_first_;  // By edge.
    std::vector<std::uint32_t> rest_;
};

/// Makes edges adjacent that are likely to be contour edges for the same view points.
void sort_by_facing(const PlanedTriangles& from, std::span<Edge> edges) {
    const auto& [source, planes] = from;
    const double radius = std::max(double(source.bounds.radius()), 1e-30);
    std::ranges::sort(edges, {}, &Edge::triangles);  // The order of edges in equal places.
    std::vector<EdgePlace> places(edges.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
        Edge& edge = edges[e];
        DualPoint a = dual_point(planes, edge.triangles[0]), b = dual_point(planes, edge.triangles[1]);
        // Orient similar edges in the same way.
        constexpr DualPoint some_direction{0.62, 0.53, 0.57, 0};
        if (std::inner_product(a.begin(), a.end(), some_direction.begin(), 0.0) <
            std::inner_product(b.begin(), b.end(), some_direction.begin(), 0.0)) {
            std::swap(a, b);
            std::swap(edge.ends[0], edge.ends[1]);
            std::swap(edge.triangles[0], edge.triangles[1]);
        }
        std::array<float, 16>& place = places[e].at;
        for (std::size_t k = 0; k < 4; ++k) {
            const double scale = k < 3 ? 1.0 : 1.0 / radius;
            place[k] = static_cast<float>(a[k] * scale);
            place[4 + k] = static_cast<float>(b[k] * scale);
        }
        const Vec3d middle =
            (Vec3d(source.positions[edge.ends[0]]) + Vec3d(source.positions[edge.ends[1]])) * 0.5;
        for (std::size_t k = 0; k < 3; ++k) place[8 + k] = static_cast<float>(middle[int(k)] / radius);
    }
    const ClusterSort sorted(places);
    const std::vector<Edge> unsorted(edges.begin(), edges.end());
    std::ranges::transform(sorted.order(), edges.begin(), [&](std::uint32_t e) { return unsorted[e]; });
}

/// Sets an interval that rounding to floats does not shrink.
template <std::size_t dimensions>
void set_interval(SoaBoxes<dimensions>& boxes, std::size_t k, std::size_t cluster, double low, double high) {
    const auto middle = static_cast<float>((low + high) / 2);
    boxes.middle[k][cluster] = middle;
    boxes.half_extent[k][cluster] =
        std::nextafter(static_cast<float>(std::max(high - double(middle), double(middle) - low)), INFINITY);
}

/// Sets the boxes of a cluster's edges.
void fill_boxes(const PlanedTriangles& from, std::span<const Edge> of, bool regular, std::size_t cluster,
                OccluderEdges& edges) {
    const auto& [source, planes] = from;
    constexpr double huge = std::numeric_limits<double>::infinity();
    std::array<double, 11> low, high;
    low.fill(huge);
    high.fill(-huge);
    double per_altitude = 0;
    const auto enclose = [&](std::size_t k, double value) {
        low[k] = std::min(low[k], value);
        high[k] = std::max(high[k], value);
    };
    for (const Edge& edge : of)
        for (std::size_t s = 0; s < 2; ++s) {
            const std::uint32_t t = edge.triangles[s];
            if (t == source.triangles.size()) continue;
            for (const std::uint32_t v : source.triangles[t])
                for (int k = 0; k < 3; ++k) enclose(8 + std::size_t(k), double(source.positions[v][k]));
            const DualPoint dual = dual_point(planes, t);
            for (std::size_t k = 0; k < 4; ++k) enclose(4 * s + k, dual[k]);
            per_altitude = std::max(per_altitude, 1 / Vec3d(planes.x[t], planes.y[t], planes.z[t]).length());
        }
    for (std::size_t s = 0; s < 2; ++s)
        for (std::size_t k = 0; k < 4; ++k)
            if (regular)
                set_interval(edges.planes[s], k, cluster, low[4 * s + k], high[4 * s + k]);
            else
                edges.planes[s].middle[k][cluster] = nan_offset;
    edges.per_altitude[cluster] = static_cast<float>(per_altitude);
    for (std::size_t k = 0; k < 3; ++k) set_interval(edges.vertices, k, cluster, low[8 + k], high[8 + k]);
}

OccluderEdges::Cluster cluster_of(const PlanedTriangles& from, std::span<const Edge> of) {
    const auto& [source, planes] = from;
    const auto none = static_cast<std::uint32_t>(source.triangles.size());
    OccluderEdges::Cluster cluster{};
    for (std::size_t s = 0; s < 2; ++s) {
        std::fill(std::begin(cluster.planes[s][3]), std::end(cluster.planes[s][3]), nan_offset);
        std::fill(std::begin(cluster.triangles[s]), std::end(cluster.triangles[s]), none);
    }
    for (std::size_t e = 0; e < of.size(); ++e)
        for (std::size_t s = 0; s < 2; ++s) {
            const Edge& edge = of[e];
            const std::uint32_t t = edge.triangles[s];
            cluster.vertices[s][e] = cluster.apices[s][e] = edge.ends[s];
            for (int k = 0; k < 3; ++k) cluster.ends[e][s][k] = source.positions[edge.ends[s]][k];
            if (t == none) continue;
            cluster.triangles[s][e] = t;
            for (const std::uint32_t v : source.triangles[t])
                if (v != edge.ends[0] && v != edge.ends[1]) cluster.apices[s][e] = v;
            const float plane[4] = {planes.x[t], planes.y[t], planes.z[t], planes.offset[t]};
            for (std::size_t k = 0; k < 4; ++k) cluster.planes[s][k][e] = plane[k];
        }
    return cluster;
}

/// Adds clusters. Boxes of planes are set for regular edges only.
void add_clusters(const PlanedTriangles& from, std::span<const Edge> of, bool regular, OccluderEdges& edges) {
    for (std::size_t first = 0; first < of.size(); first += OccluderEdges::cluster_size) {
        const auto some = of.subspan(first, std::min(OccluderEdges::cluster_size, of.size() - first));
        fill_boxes(from, some, regular, edges.clusters.size(), edges);
        edges.clusters.push_back(cluster_of(from, some));
    }
}

}  // namespace

OccluderEdges occluder_edges(const OccluderTriangles& source, const OccluderPlanes& planes) {
    const PlanedTriangles from{source, planes};
    const auto count = static_cast<std::uint32_t>(source.triangles.size());
    const std::vector<EdgeUse> uses = sorted_edge_uses(source.triangles);
    Pieces pieces(count);
    for (std::size_t i = 1; i < uses.size(); ++i)
        if (same_edge(uses[i - 1], uses[i])) pieces.join(uses[i].triangle, uses[i - 1].triangle);
    std::vector<std::uint32_t> lone(count, 0), size(count, 0);
    std::vector<Edge> all = matched_edges(uses, count, pieces, lone);
    for (std::uint32_t t = 0; t < count; ++t) ++size[pieces.root(t)];

    // A lone edge is always drawn, and costs about half a triangle.
    const auto is_loose = [&](std::uint32_t t) { return 2 * lone[pieces.root(t)] > size[pieces.root(t)]; };
    std::erase_if(all, [&](const Edge& e) { return is_loose(std::min(e.triangles[0], e.triangles[1])); });
    OccluderEdges edges;
    edges.loose.assign((count + 63) / 64, 0);
    for (std::uint32_t t = 0; t < count; ++t) edges.loose[t / 64] |= std::uint64_t(is_loose(t)) << (t % 64);

    const auto is_regular = [&](const Edge& e) {
        const auto [a, b] = e.triangles;
        return a != count && b != count && std::isfinite(planes.offset[a]) &&
               std::isfinite(planes.offset[b]) && (a < source.one_sided) == (b < source.one_sided);
    };
    const auto is_one_sided = [&](const Edge& e) { return e.triangles[0] < source.one_sided; };
    const auto regular_end = std::stable_partition(all.begin(), all.end(), is_regular),
               one_sided_end = std::stable_partition(all.begin(), regular_end, is_one_sided);
    const std::span one_sided(all.begin(), one_sided_end), two_sided(one_sided_end, regular_end),
        others(regular_end, all.end());
    const std::size_t boxes = all.size() / OccluderEdges::cluster_size + 3 + widest_vector<float>;
    const auto reserve = [&](auto& of) {
        for (auto& values : of.middle) values.assign(boxes, 0.0f);
        for (auto& values : of.half_extent) values.assign(boxes, 0.0f);
    };
    reserve(edges.planes[0]);
    reserve(edges.planes[1]);
    reserve(edges.vertices);
    edges.per_altitude.assign(boxes, 0.0f);
    sort_by_facing(from, one_sided);
    add_clusters(from, one_sided, true, edges);
    edges.one_sided_clusters = static_cast<std::uint32_t>(edges.clusters.size());
    sort_by_facing(from, two_sided);
    add_clusters(from, two_sided, true, edges);
    add_clusters(from, others, false, edges);
    return edges;
}

}  // namespace haarfield
