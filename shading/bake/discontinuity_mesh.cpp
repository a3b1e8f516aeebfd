#include "shading/bake/discontinuity_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace haarfield {
namespace {

/// The share of the difference between the ends of an edge that the interval must keep.
constexpr float kept_share = 0.75f;
/// Bisections of an edge; intervals longer than `longest` are penumbrae, which refinement resolves.
constexpr int bisections = 6;
constexpr double longest = 0.25;
constexpr std::uint32_t no_parts = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t no_vertex = std::numeric_limits<std::uint32_t>::max();

/// An edge with the interval that contains the discontinuity, from its lower vertex (0) to the other one (1).
struct CutEdge {
    struct End {
        double place = 0;
        Outgoing radiance;
        Vec3f sample{0, 0, 0};  ///< SurfacePoint::sample, unless the end is a vertex of the edge.
    };

    std::size_t instance = 0;
    std::uint32_t edge = 0;
    EdgeBisection::Side side;
    float whole = 0;   ///< Difference between the ends of the edge.
    float tinted = 0;  ///< The same with tints.
    End low, high;
    bool is_open = true;  ///< May become shorter.

    double length() const { return high.place - low.place; }
};

GatheredIrradiance mixed_irradiance(const UncutMesh& mesh, const EdgeBisection::Side& side, double place) {
    const auto share = static_cast<float>(place);
    const GatheredIrradiance &a = mesh.irradiance[side.low], &b = mesh.irradiance[side.high];
    return {a.irradiance * (1 - share) + b.irradiance * share, std::max(a.nearness, b.nearness)};
}

std::vector<CutEdge> candidates(std::span<const UncutMesh> meshes, float contrast) {
    std::vector<CutEdge> edges;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const UncutMesh& mesh = meshes[i];
        const std::span<const EdgeBisection::Edge> all = mesh.bisection->edges();
        for (std::uint32_t e = 0; e < all.size(); ++e) {
            if (!mesh.candidates[e] || all[e].triangles.empty()) continue;
            std::vector<EdgeBisection::Side> sides = mesh.bisection->sides(e);
            if (sides.size() != 1 || mesh.samples->buried[sides[0].low] ||
                mesh.samples->buried[sides[0].high])
                continue;
            CutEdge edge;
            edge.instance = i;
            edge.edge = e;
            edge.side = std::move(sides[0]);
            edge.high.place = 1;
            edge.low.radiance = mesh.radiance[edge.side.low];
            edge.high.radiance = mesh.radiance[edge.side.high];
            edge.whole = channel_difference(edge.low.radiance, edge.high.radiance);
            const Rgb tint = mesh.tints.empty()
                                 ? Rgb(1.0f)
                                 : (mesh.tints[edge.side.low] + mesh.tints[edge.side.high]) * 0.5f;
            edge.tinted =
                channel_difference(tinted(edge.low.radiance, tint), tinted(edge.high.radiance, tint));
            if (edge.tinted > contrast) edges.push_back(std::move(edge));
        }
    }
    return edges;
}

/// Halves the intervals of all edges that keep the discontinuity.
Result<Done> halve(const PointShading& shading, std::span<const UncutMesh> meshes, const PlacedSolids& solids,
                   std::vector<CutEdge>& edges, const Progress& progress) {
    std::vector<std::optional<SurfacePoint>> middles(edges.size());
    tbb::parallel_for(std::size_t{0}, edges.size(), [&](std::size_t n) {
        const CutEdge& edge = edges[n];
        if (!edge.is_open) return;
        const Mesh& mesh = meshes[edge.instance].bisection->mesh();
        const double place = (edge.low.place + edge.high.place) / 2;
        const EntityOcclusion& occlusion =
            *shading.scene.entities[shading.scene.instances[edge.instance].entity].occlusion;
        const Vec3d low(mesh.positions[edge.side.low]), high(mesh.positions[edge.side.high]);
        middles[n] = point_on(mesh, edge.side.triangles, Vec3f(low * (1 - place) + high * place),
                              interpolated_normal(mesh, edge.side, place), occlusion.sampler());
        if (middles[n] && solids.contain(shading.scene, edge.instance, *middles[n])) middles[n].reset();
    });
    std::vector<InstancePoint> points;
    for (std::size_t n = 0; n < edges.size(); ++n) {
        CutEdge& edge = edges[n];
        edge.is_open = edge.is_open && middles[n];
        if (!edge.is_open) continue;
        InstancePoint& point = points.emplace_back(InstancePoint{edge.instance, *middles[n]});
        if (shading.indirect)
            point.irradiance =
                mixed_irradiance(meshes[edge.instance], edge.side, (edge.low.place + edge.high.place) / 2)
                    .irradiance;
    }
    Progress silent;
    silent.stop = progress.stop;
    HF_TRY(const std::vector<Outgoing> radiance, point_radiance(shading, points, silent));
    auto next = radiance.begin();
    for (std::size_t n = 0; n < edges.size(); ++n) {
        CutEdge& edge = edges[n];
        if (!edge.is_open) continue;
        const CutEdge::End middle{(edge.low.place + edge.high.place) / 2, *next++, middles[n]->sample};
        const float before = channel_difference(edge.low.radiance, middle.radiance),
                    after = channel_difference(middle.radiance, edge.high.radiance);
        edge.is_open = std::max(before, after) >= kept_share * edge.whole;
        if (edge.is_open) (before > after ? edge.high : edge.low) = middle;
    }
    return Done{};
}

/// Returns the difference between the ends of an edge times its length in the world. [W/(m sr)]
double gain_of(const ShadedScene& scene, std::span<const UncutMesh> meshes, const CutEdge& edge) {
    return double(edge.tinted) * double(scene.instances[edge.instance].placement.scale) *
           std::sqrt(meshes[edge.instance].bisection->squared_length(edge.edge));
}

/// True if a sample of the edges has enough discontinuities for the others to be searched. The probability of
/// an edge is about proportional to the square error that a discontinuity on it would cause, which is the
/// square of the difference times an area.
Result<bool> are_worthwhile(const PointShading& shading, std::span<const UncutMesh> meshes,
                            const PlacedSolids& solids, const std::vector<CutEdge>& edges,
                            const Progress& progress) {
    constexpr std::size_t sample_size = 256;
    constexpr double least_share = 0.25;
    if (edges.size() <= sample_size) return true;
    std::vector<double> up_to;  // Sums of the squares of gains.
    for (const CutEdge& edge : edges)
        up_to.push_back((up_to.empty() ? 0 : up_to.back()) +
                        std::pow(gain_of(shading.scene, meshes, edge), 2));
    std::vector<CutEdge> sample;
    std::vector<std::size_t> times;  // By edge of the sample: how often it was chosen.
    for (std::size_t n = 0, next = 0, last = edges.size(); n < sample_size; ++n) {
        const double place = (double(n) + 0.5) / double(sample_size) * up_to.back();
        while (next + 1 < edges.size() && up_to[next] < place) ++next;
        if (next != last) {
            sample.push_back(edges[next]);
            times.push_back(0);
        }
        ++times.back();
        last = next;
    }
    for (int step = 0; step < bisections; ++step)
        HF_TRY_DONE(halve(shading, meshes, solids, sample, progress));
    std::size_t found = 0;
    for (std::size_t n = 0; n < sample.size(); ++n)
        if (sample[n].length() <= longest) found += times[n];
    return double(found) >= least_share * double(sample_size);
}

/// Keeps the edges whose discontinuity was found, as many as the vertices allow.
void choose(const ShadedScene& scene, std::span<const UncutMesh> meshes, std::size_t most_vertices,
            std::vector<CutEdge>& edges) {
    std::erase_if(edges, [](const CutEdge& edge) { return edge.length() > longest; });
    std::ranges::stable_sort(edges, std::ranges::greater(),
                             [&](const CutEdge& edge) { return gain_of(scene, meshes, edge); });
    std::size_t vertices = 0, chosen = 0;
    for (const UncutMesh& mesh : meshes) vertices += mesh.radiance.size();
    for (; chosen < edges.size(); ++chosen) {
        vertices += (edges[chosen].low.place > 0) + (edges[chosen].high.place < 1);
        if (vertices > most_vertices) break;
    }
    edges.erase(edges.begin() + static_cast<std::ptrdiff_t>(chosen), edges.end());
}

/// Adds a vertex for an end of an interval, unless it is a vertex of the edge. Returns its index.
std::uint32_t added_vertex(const UncutMesh& uncut, const EdgeBisection::Side& side, const CutEdge::End& end,
                           RadiantMesh& result) {
    if (end.place == 0) return side.low;
    if (end.place == 1) return side.high;
    const std::uint32_t vertex = add_interpolated_vertex(result.mesh, side, end.place);
    result.radiance.push_back(end.radiance);
    result.samples.points.push_back(end.sample);
    result.samples.buried.push_back(0);
    if (!result.irradiance.empty()) result.irradiance.push_back(mixed_irradiance(uncut, side, end.place));
    return vertex;
}

/// A corner of a part of a triangle.
struct Corner {
    std::uint32_t vertex = no_vertex;
    std::array<float, 3> weights{};  ///< Of the triangle's corners.
};

/// The ends of the interval on an edge of a triangle, in the order of its corners.
struct CrossedSide {
    Corner first, second;
    bool is_cut = false;
};

/// Divides the triangles of one mesh.
class TriangleCutter {
public:
    TriangleCutter(RadiantMesh& result, std::vector<std::uint32_t>& parts_of,
                   std::vector<std::vector<DiscontinuityMeshes::Part>>& parts)
        : result_(result), parts_of_(parts_of), parts_(parts) {}

    void operator()(std::uint32_t triangle, const std::array<CrossedSide, 3>& sides) {
        std::array<Corner, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            corners[k].vertex = result_.mesh.triangles[triangle][k];
            corners[k].weights[k] = 1;
        }
        parts_now_.clear();
        const auto count = std::ranges::count(sides, true, &CrossedSide::is_cut);
        if (count == 1) {
            std::size_t k = 0;
            while (!sides[k].is_cut) ++k;
            const Corner &from = corners[k], &to = corners[(k + 1) % 3], &opposite = corners[(k + 2) % 3];
            add_polygon({from, sides[k].first, opposite});
            add_polygon({sides[k].first, sides[k].second, opposite});
            add_polygon({sides[k].second, to, opposite});
        } else if (count == 2) {
            std::size_t k = 0;
            while (sides[k].is_cut) ++k;
            // The cut edges meet at the corner opposite to edge k.
            const Corner &x = corners[k], &y = corners[(k + 1) % 3], &tip = corners[(k + 2) % 3];
            const CrossedSide &arriving = sides[(k + 1) % 3], &leaving = sides[(k + 2) % 3];
            add_polygon({arriving.second, tip, leaving.first});
            add_polygon({arriving.first, arriving.second, leaving.first, leaving.second});
            add_polygon({x, y, arriving.first, leaving.second});
        } else {
            for (std::size_t k = 0; k < 3; ++k)
                add_polygon({sides[(k + 2) % 3].second, corners[k], sides[k].first});
            add_polygon({sides[0].first, sides[0].second, sides[1].first, sides[1].second, sides[2].first,
                         sides[2].second});
        }
        store(triangle);
    }

private:
    /// Adds a convex polygon of at most six corners, some of which may be the same vertex.
    void add_polygon(std::initializer_list<Corner> given) {
        std::array<Corner, 6> corners;
        std::size_t count = 0;
        for (const Corner& corner : given) {
            if (count > 0 && corners[count - 1].vertex == corner.vertex) --count;
            corners[count++] = corner;
        }
        while (count > 1 && corners[count - 1].vertex == corners[0].vertex) --count;
        const auto diagonal = [&](std::size_t from) {
            return (result_.mesh.positions[corners[from].vertex] -
                    result_.mesh.positions[corners[from + 2].vertex])
                .length2();
        };
        if (count == 4 && diagonal(1) < diagonal(0))
            std::rotate(corners.begin(), corners.begin() + 1, corners.begin() + 4);
        for (std::size_t n = 2; n < count; ++n)
            parts_now_.push_back({{corners[0].vertex, corners[n - 1].vertex, corners[n].vertex},
                                  {corners[0].weights, corners[n - 1].weights, corners[n].weights}});
    }

    void store(std::uint32_t triangle) {
        auto& triangles = result_.mesh.triangles;
        triangles[triangle] = parts_now_.front().vertices;
        for (std::size_t n = 1; n < parts_now_.size(); ++n) triangles.push_back(parts_now_[n].vertices);
        parts_of_[triangle] = static_cast<std::uint32_t>(parts_.size());
        parts_.push_back(parts_now_);
    }

    RadiantMesh& result_;
    std::vector<std::uint32_t>& parts_of_;
    std::vector<std::vector<DiscontinuityMeshes::Part>>& parts_;
    std::vector<DiscontinuityMeshes::Part> parts_now_;
};

}  // namespace

Result<DiscontinuityMeshes> DiscontinuityMeshes::make(const PointShading& shading,
                                                      std::span<const UncutMesh> meshes,
                                                      const PlacedSolids& solids, float contrast,
                                                      std::size_t most_vertices, CutSearch extent,
                                                      const Progress& progress) {
    std::vector<CutEdge> edges = candidates(meshes, contrast);
    if (extent == CutSearch::sampled) {
        HF_TRY(const bool is_worthwhile, are_worthwhile(shading, meshes, solids, edges, progress));
        if (!is_worthwhile) edges.clear();
    }
    for (int step = 0; step < bisections; ++step)
        HF_TRY_DONE(halve(shading, meshes, solids, edges, progress));
    choose(shading.scene, meshes, most_vertices, edges);

    DiscontinuityMeshes result;
    result.cut_edges_ = edges.size();
    std::vector<std::vector<std::array<CrossedSide, 3>>> crossed;
    for (const UncutMesh& mesh : meshes) {
        result.meshes_.push_back({mesh.bisection->mesh(),
                                  {mesh.radiance.begin(), mesh.radiance.end()},
                                  *mesh.samples,
                                  {mesh.irradiance.begin(), mesh.irradiance.end()}});
        const std::size_t triangles = mesh.bisection->mesh().triangles.size();
        result.parts_of_.emplace_back(triangles, no_parts);
        crossed.emplace_back(triangles);
    }
    result.parts_.resize(meshes.size());
    for (const CutEdge& edge : edges) {
        RadiantMesh& mesh = result.meshes_[edge.instance];
        const std::size_t before = mesh.radiance.size();
        const UncutMesh& uncut = meshes[edge.instance];
        const std::uint32_t low = added_vertex(uncut, edge.side, edge.low, mesh),
                            high = added_vertex(uncut, edge.side, edge.high, mesh);
        result.added_vertices_ += mesh.radiance.size() - before;
        for (const std::uint32_t t : edge.side.triangles) {
            const auto& around = uncut.bisection->edges_of(t);
            const auto k = static_cast<std::size_t>(std::ranges::find(around, edge.edge) - around.begin());
            const bool is_forward = uncut.bisection->mesh().triangles[t][k] == edge.side.low;
            const auto corner = [&](std::uint32_t vertex, double place) {
                Corner at{vertex, {}};
                const double from_k = is_forward ? place : 1 - place;
                at.weights[k] = static_cast<float>(1 - from_k);
                at.weights[(k + 1) % 3] = static_cast<float>(from_k);
                return at;
            };
            const Corner at_low = corner(low, edge.low.place), at_high = corner(high, edge.high.place);
            crossed[edge.instance][t][k] =
                is_forward ? CrossedSide{at_low, at_high, true} : CrossedSide{at_high, at_low, true};
        }
    }
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        TriangleCutter cut(result.meshes_[i], result.parts_of_[i], result.parts_[i]);
        for (std::uint32_t t = 0; t < crossed[i].size(); ++t)
            if (std::ranges::any_of(crossed[i][t], &CrossedSide::is_cut)) cut(t, crossed[i][t]);
    }
    return result;
}

DiscontinuityMeshes::Located DiscontinuityMeshes::located(std::size_t instance, std::uint32_t triangle,
                                                          const std::array<float, 3>& weights) const {
    const std::uint32_t parts = parts_of_[instance][triangle];
    if (parts == no_parts) return {meshes_[instance].mesh.triangles[triangle], weights};
    Located best;
    float inside = -std::numeric_limits<float>::infinity();
    for (const Part& part : parts_[instance][parts]) {
        const auto& [a, b, c] = part.corners;
        const auto area = [](const std::array<float, 3>& p, const std::array<float, 3>& q,
                             const std::array<float, 3>& r) {
            return (q[1] - p[1]) * (r[2] - p[2]) - (r[1] - p[1]) * (q[2] - p[2]);
        };
        const float whole = area(a, b, c);
        if (whole == 0) continue;
        const std::array<float, 3> found{area(weights, b, c) / whole, area(a, weights, c) / whole,
                                         area(a, b, weights) / whole};
        const float least = std::min({found[0], found[1], found[2]});
        if (least > inside) {
            inside = least;
            best = {part.vertices, found};
        }
    }
    return best;
}

}  // namespace haarfield
