#include "shading/transfer/source_rows.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <optional>

namespace haarfield {
namespace {

constexpr std::size_t run = 64;  ///< In rows.

/// The rows [first, end) that are not buried, with their receivers.
struct RowRun {
    std::vector<std::uint32_t> rows;
    std::vector<ShadingPoint> receivers;

    RowRun(const ShadedScene& scene, const VertexRows& all, std::size_t first, std::size_t end) {
        for (std::size_t row = first; row < end; ++row) {
            const InstanceVertex at = all[row];
            if (all.is_buried(at)) continue;
            rows.push_back(static_cast<std::uint32_t>(row));
            receivers.push_back(shading_point(scene, scene.instances[at.instance], at.vertex));
        }
    }
};

/// Calls `act` with the index of a run of rows, and its range [first, end).
template <class Act>
Result<Done> for_each_run(std::size_t begin, std::size_t end, const Progress& progress, const Act& act) {
    tbb::parallel_for(std::size_t(0), (end - begin + run - 1) / run, [&](std::size_t block) {
        if (progress.stop.stop_requested()) return;
        act(block, begin + block * run, std::min(end, begin + (block + 1) * run));
    });
    if (progress.stop.stop_requested()) return interruption();
    return Done{};
}

/// The order in which the visibility of a mesh's vertices is determined: some vertices first, others after a
/// sufficient number of their neighbours.
struct AskedLater {
    static constexpr std::uint8_t rounds = 5;
    static constexpr std::size_t enough = 3;
    std::vector<std::uint8_t> round;             ///< By vertex; the last round for those without enough
                                                 ///< neighbours.
    std::vector<std::uint32_t> neighbours, end;  ///< Of each vertex, without duplicates.

    AskedLater(const Mesh& mesh, std::span<const std::uint8_t> buried)
        : round(mesh.positions.size(), rounds - 1) {
        list_neighbours(mesh);
        const std::vector<std::uint8_t> left_out = left_out_vertices(mesh, buried);
        for (std::size_t v = 0; v < round.size(); ++v)
            if (!left_out[v]) round[v] = 0;
        for (std::uint8_t r = 1; r + 1 < rounds; ++r)
            for (std::uint32_t v = 0; v < round.size(); ++v)
                if (round[v] >= r && !buried[v] && has_enough(v, r)) round[v] = r;
        for (std::uint32_t v = 0; v < round.size(); ++v)  // Buried vertices provide no visibility.
            if (buried[v]) round[v] = rounds;
    }

    /// Calls `act` with the neighbours in earlier rounds; with none if these are not enough.
    template <class Act>
    void for_each_earlier(std::uint32_t vertex, const Act& act) const {
        if (!has_enough(vertex, round[vertex])) return;
        for (const std::uint32_t v : beside(vertex))
            if (round[v] < round[vertex]) act(v);
    }

private:
    std::span<const std::uint32_t> beside(std::uint32_t vertex) const {
        const std::size_t first = vertex > 0 ? end[vertex - 1] : 0;
        return std::span(neighbours).subspan(first, end[vertex] - first);
    }

    /// Tests whether a vertex has enough neighbours in rounds before `than`.
    bool has_enough(std::uint32_t vertex, std::uint8_t than) const {
        return std::size_t(std::ranges::count_if(beside(vertex),
                                                 [&](std::uint32_t v) { return round[v] < than; })) >= enough;
    }

    void list_neighbours(const Mesh& mesh) {
        // Lists two neighbours per triangle for each of its vertices, then removes duplicates.
        std::vector<std::uint32_t> first(mesh.positions.size() + 1, 0);
        for (const auto& triangle : mesh.triangles)
            for (const std::uint32_t v : triangle) first[v + 1] += 2;
        std::partial_sum(first.begin(), first.end(), first.begin());
        std::vector<std::uint32_t> all(first.back()), filled(first.begin(), first.end() - 1);
        for (const auto& triangle : mesh.triangles)
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t next = 1; next < 3; ++next)
                    all[filled[triangle[k]]++] = triangle[(k + next) % 3];
        neighbours.reserve(all.size() / 2);
        for (std::size_t v = 0; v + 1 < first.size(); ++v) {
            const auto of_vertex = std::span(all).subspan(first[v], first[v + 1] - first[v]);
            std::ranges::sort(of_vertex);
            neighbours.insert(neighbours.end(), of_vertex.begin(),
                              std::unique(of_vertex.begin(), of_vertex.end()));
            end.push_back(static_cast<std::uint32_t>(neighbours.size()));
        }
    }
};

/// Sets the visibility of clusters that all neighbours agree on; leaves the others unchanged.
///
/// beside  places of the neighbours in `seen`, or empty.
void set_common_visibility(std::span<const ClusterVisibility> seen, std::span<const std::uint32_t> beside,
                           std::span<ClusterVisibility> visibility) {
    if (beside.empty()) return;
    const std::size_t count = visibility.size();
    for (std::size_t c = 0; c < count; ++c) {
        const ClusterVisibility common = seen[beside[0] * count + c];
        if (std::ranges::all_of(beside, [&](std::uint32_t i) { return seen[i * count + c] == common; }))
            visibility[c] = common;
    }
}

/// Tests whether a ray may intersect a sphere; the direction is a unit vector.
bool may_meet(const Sphere& sphere, const Vec3f& from, const Vec3f& direction) {
    const Vec3f to_centre = sphere.centre - from;
    const float along = to_centre.dot(direction), squared_radius = sphere.radius * sphere.radius,
                squared_distance = to_centre.length2();
    if (squared_distance <= squared_radius) return true;
    return along > 0 && squared_distance - along * along <= squared_radius;
}

/// Returns a sphere slightly larger than an instance in its placement.
Sphere bounding_sphere(const ShadedScene& scene, const ShadedInstance& instance) {
    const Bounds& bounds = scene.entities[instance.entity].occlusion->original().bounds();
    return {instance.placement.point_to_world(bounds.centre()),
            1.001f * instance.placement.scale * bounds.radius()};
}

}  // namespace

Result<SourceRows> SourceRows::make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                    const Progress& progress) {
    std::vector<std::optional<AskedLater>> asked(scene.entities.size());
    tbb::parallel_for(std::size_t(0), asked.size(), [&](std::size_t e) {
        if (progress.stop.stop_requested()) return;
        const ShadedEntity& entity = scene.entities[e];
        asked[e].emplace(*entity.mesh, entity.occlusion->samples().buried);
    });
    const VertexRows rows(scene, geometry);
    std::vector<std::optional<RowRun>> runs((rows.count() + run - 1) / run);
    HF_TRY_DONE(
        for_each_run(0, rows.count(), progress, [&](std::size_t block, std::size_t first, std::size_t end) {
            runs[block].emplace(scene, rows, first, end);
        }));
    SourceRows result;
    result.rounds_.resize(AskedLater::rounds);
    std::vector<std::vector<std::uint32_t>> place(scene.instances.size());  // By instance and vertex.
    for (std::size_t i = 0; i < place.size(); ++i) place[i].resize(rows.vertices(i).size());
    for (std::size_t r = 0; r < result.rounds_.size(); ++r) {
        if (progress.stop.stop_requested()) return interruption();
        Round& round = result.rounds_[r];
        if (r > 0) round.first = result.rounds_[r - 1].first + result.rounds_[r - 1].rows.size();
        for (const std::optional<RowRun>& of : runs)
            for (std::size_t k = 0; k < of->rows.size(); ++k) {
                const auto [instance, vertex] = rows[of->rows[k]];
                const AskedLater& order = *asked[scene.instances[instance].entity];
                if (order.round[vertex] != r) continue;
                std::vector<std::uint32_t>& places = place[instance];
                places[vertex] = static_cast<std::uint32_t>(round.first + round.rows.size());
                order.for_each_earlier(vertex,
                                       [&](std::uint32_t v) { round.neighbours.push_back(places[v]); });
                round.end.push_back(static_cast<std::uint32_t>(round.neighbours.size()));
                round.rows.push_back(of->rows[k]);
                round.receivers.push_back(of->receivers[k]);
            }
    }
    return result;
}

Result<Done> SourceRows::add(const ShadowRays& rays, std::span<const DirectionalLight> lights,
                             FrameQuality quality, std::span<Rgb> by_row, std::span<Rgb> diffuse,
                             const Progress& progress) const {
    if (lights.empty() || rounds_.empty()) return Done{};
    const std::vector<LightCluster> clusters = light_clusters(lights);
    const std::size_t count = clusters.size();
    std::vector<ClusterVisibility> seen((rounds_.back().first + rounds_.back().rows.size()) * count);
    for (const Round& round : rounds_) {
        const auto add_run = [&](std::size_t, std::size_t first, std::size_t end) {
            const std::size_t size = end - first;
            std::array<Rgb, run> added, added_diffuse;
            added.fill(Rgb(0.0f));
            added_diffuse.fill(Rgb(0.0f));
            const auto visibility = std::span(seen).subspan((round.first + first) * count, size * count);
            if (quality == FrameQuality::moving)
                for (std::size_t k = first; k < end; ++k) {
                    const std::size_t begin = k > 0 ? round.end[k - 1] : 0;
                    set_common_visibility(seen,
                                          std::span(round.neighbours).subspan(begin, round.end[k] - begin),
                                          visibility.subspan((k - first) * count, count));
                }
            add_clustered_light(rays, clusters, std::span(round.receivers).subspan(first, size),
                                std::span(added).first(size),
                                std::span(added_diffuse).first(diffuse.empty() ? 0 : size), visibility);
            for (std::size_t k = 0; k < size; ++k) by_row[round.rows[first + k]] += added[k];
            for (std::size_t k = 0; k < size && !diffuse.empty(); ++k)
                diffuse[round.rows[first + k]] += added_diffuse[k];
        };
        HF_TRY_DONE(for_each_run(0, round.rows.size(), progress, add_run));
    }
    return Done{};
}

std::size_t SourceRows::bytes() const {
    std::size_t sum = 0;
    for (const Round& round : rounds_)
        sum += round.rows.size() * (2 * sizeof(std::uint32_t) + sizeof(ShadingPoint)) +
               round.neighbours.size() * sizeof(std::uint32_t);
    return sum;
}

Result<StaticSources> static_sources(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     std::size_t moving, std::vector<DirectionalLight> lights,
                                     std::span<Rgb> by_row, const Progress& progress) {
    const VertexRows rows(scene, geometry);
    StaticSources result{moving, std::move(lights), {}};
    const std::size_t words = result.words();
    result.lit.resize(rows.count() * words);
    const auto find = [&](std::size_t, std::size_t first, std::size_t end) {
        const RowRun here(scene, rows, first, end);
        for (std::size_t begin = 0; begin < here.rows.size(); begin += ShadowRays::packet) {
            const ReceiverPacket packet(
                std::span(here.receivers)
                    .subspan(begin, std::min(ShadowRays::packet, here.rows.size() - begin)));
            std::uint16_t others = 0;
            for (std::size_t i = 0; i < packet.size(); ++i)
                others = static_cast<std::uint16_t>(
                    others | unsigned(rows[here.rows[begin + i]].instance != moving) << i);
            for (std::size_t l = 0; l < result.lights.size(); ++l) {
                const DirectionalLight& light = result.lights[l];
                const std::uint16_t lit = packet.lit(geometry.rays, light.direction, others, moving);
                for (std::size_t i = 0; i < packet.size(); ++i) {
                    if (!(lit >> i & 1u)) continue;
                    const std::uint32_t row = here.rows[begin + i];
                    result.lit[row * words + l / 64] |= std::uint64_t(1) << (l % 64);
                    by_row[row] += reflectance(packet[i].brdf, light.direction).total() * light.irradiance;
                }
            }
        }
    };
    HF_TRY_DONE(for_each_run(0, rows.count(), progress, find));
    return result;
}

Result<Done> move_in_sources(const StaticSources& sources, const ShadedScene& scene,
                             const ShadingGeometry& geometry, std::span<Rgb> by_row,
                             const Progress& progress) {
    if (sources.lights.empty()) return Done{};
    const VertexRows rows(scene, geometry);
    const std::size_t words = sources.words(), own = rows.first(sources.moving);
    const Sphere sphere = bounding_sphere(scene, scene.instances[sources.moving]);
    const auto take = [&](std::size_t, std::size_t first, std::size_t end) {
        for (std::size_t row = first; row < end; ++row) {
            const std::span<const std::uint64_t> lit = std::span(sources.lit).subspan(row * words, words);
            if (std::ranges::all_of(lit, [](std::uint64_t word) { return word == 0; })) continue;
            const InstanceVertex at = rows[row];
            const ShadedInstance& instance = scene.instances[at.instance];
            const ShadedEntity& entity = scene.entities[instance.entity];
            const SurfacePoint point = surface_point(entity, at.vertex);
            const Vec3f from = instance.placement.point_to_world(point.sample);
            std::optional<VertexBrdf> brdf;
            for (std::size_t word = 0; word < words; ++word)
                for (std::uint64_t left = lit[word]; left != 0; left &= left - 1) {
                    const DirectionalLight& light =
                        sources.lights[64 * word + std::size_t(std::countr_zero(left))];
                    if (!may_meet(sphere, from, light.direction) ||
                        !geometry.rays.is_blocked(from, light.direction))
                        continue;
                    if (!brdf) brdf = shading_point(scene, instance, point).brdf;
                    by_row[row] -= reflectance(*brdf, light.direction).total() * light.irradiance;
                }
        }
    };
    HF_TRY_DONE(for_each_run(0, rows.count(), progress, take));
    const std::vector<LightCluster> clusters = light_clusters(sources.lights);
    const auto add = [&](std::size_t, std::size_t first, std::size_t end) {
        const RowRun here(scene, rows, first, end);
        std::array<Rgb, run> added;
        added.fill(Rgb(0.0f));
        add_clustered_light(geometry.rays, clusters, here.receivers,
                            std::span(added).first(here.rows.size()));
        for (std::size_t k = 0; k < here.rows.size(); ++k) by_row[here.rows[k]] += added[k];
    };
    return for_each_run(own, own + rows.vertices(sources.moving).size(), progress, add);
}

std::size_t SourceVisibility::bytes() const {
    std::size_t sum = 0;
    for (const std::vector<VisibleFraction>& block : blocks) sum += block.size() * sizeof(VisibleFraction);
    return sum;
}

Result<SourceVisibility> source_visibility(const ShadedScene& scene, const ShadingGeometry& geometry,
                                           std::span<const LightSource> sources, std::span<Rgb> diffuse,
                                           const Progress& progress) {
    const VertexRows rows(scene, geometry);
    SourceVisibility result;
    if (sources.empty()) return result;
    result.blocks.resize((rows.count() + run - 1) / run);
    HF_TRY_DONE(
        for_each_run(0, rows.count(), progress, [&](std::size_t block, std::size_t first, std::size_t end) {
            const RowRun here(scene, rows, first, end);
            const std::size_t count = here.rows.size();
            for (const LightSource& source : sources) {
                std::array<VisibleLights, run> lit;
                add_lit_parts(geometry.rays, source.lights, here.receivers, std::span(lit).first(count));
                for (std::size_t k = 0; k < count; ++k) {
                    if (lit[k].irradiance == Rgb(0.0f)) continue;
                    diffuse[here.rows[k]] += here.receivers[k].brdf.diffuse * lit[k].by_cosine;
                    if (here.receivers[k].brdf.specular != Rgb(0.0f))
                        result.blocks[block].push_back(
                            {here.rows[k], {lit[k].direction.normalized(), lit[k].irradiance}});
                }
            }
        }));
    return result;
}

Result<Done> add_source_specular(const SourceVisibility& visibility, const ShadedScene& scene,
                                 const ShadingGeometry& geometry, std::span<Rgb> by_row,
                                 const VertexMask* wanted, const Progress& progress) {
    if (visibility.blocks.empty()) return Done{};
    const VertexRows rows(scene, geometry);
    return for_each_run(0, rows.count(), progress, [&](std::size_t block, std::size_t, std::size_t) {
        for (const auto& [row, light] : visibility.blocks[block]) {
            const InstanceVertex at = rows[row];
            if (wanted && !(*wanted)[at.instance][at.vertex]) continue;
            const ShadingPoint point = shading_point(scene, scene.instances[at.instance], at.vertex);
            by_row[row] += specular_reflectance(point.brdf, light.direction) * light.irradiance;
        }
    });
}

}  // namespace haarfield
