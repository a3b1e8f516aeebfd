#include "shading/bake/mesh_refinement.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "fields/mesh/edge_bisection.h"
#include "shading/bake/colour_fit.h"
#include "shading/visibility/placed_solids.h"

namespace haarfield {
namespace {

constexpr float not_shaded = -1;
/// Irradiance is interpolated along edges that are shorter than this share of the distance to other surfaces
/// (1 / nearness), whose normals turn less than this, and whose ends differ less than this.
constexpr float interpolated_length = 0.1f, least_cosine = 0.995f, largest_difference = 0.05f;
/// The smallest difference between the ends of edges that are cut, in tolerances.
constexpr float cut_contrast = 8;
/// The smallest errors of KnownPoints for which triangles are divided, in tolerances.
constexpr float known_error = 8;
/// The weight of errors that are not in the picture.
constexpr double hidden_share = 0.25;
/// Edges below the first length are not split, nor those below the second one that look shorter than the
/// third one from the eye. [radii, radii, distances]
constexpr double shortest_edge = 2e-5, usual_edge = 2e-4, viewed_edge = 1.0 / 1500;

float channel_sum(const Outgoing& radiance) {
    const Rgb c = radiance.total();
    return c.x + c.y + c.z;
}

/// The shaded middle of an edge, on all its sides.
struct Middle {
    float error = not_shaded;  ///< The largest error of all sides.
    /// Before it is shaded: the largest error in the triangles that were split to make this edge.
    float expected = std::numeric_limits<float>::infinity();
    float known = 0;         ///< The largest error of KnownPoints in triangles whose longest edge it is.
    bool is_final = false;   ///< It cannot be split.
    bool is_visible = true;  ///< Both ends are in the picture, on any side.
    float difference = 0;    ///< The largest difference of all sides, not relative.
    /// The largest error of interpolated indirect irradiance, of all sides, as `error`. Before the middle is
    /// shaded: that in the triangles that were split to make this edge; infinite if unknown.
    float indirect_error = std::numeric_limits<float>::infinity();
    std::vector<Outgoing> radiance;              ///< By EdgeBisection::sides.
    LocalSamples samples;                        ///< By EdgeBisection::sides.
    std::vector<GatheredIrradiance> irradiance;  ///< By EdgeBisection::sides.
};

/// An instance during refinement.
struct RefinedInstance {
    EdgeBisection bisection;
    std::vector<Outgoing> radiance;
    LocalSamples samples;
    std::vector<std::uint8_t> visible;           ///< By vertex: false if it is not in the picture.
    std::vector<GatheredIrradiance> irradiance;  ///< By vertex.
    std::vector<Rgb> tints;                      ///< ShadedEntity::tints, also of added vertices.
    std::vector<Middle> middles;                 ///< By edge.
    float scale;
    double radius;             ///< Of the entity. [m]
    std::optional<Vec3f> eye;  ///< In the entity's frame; present if edges are viewed from there. [m]

    bool is_shaded(std::uint32_t edge) const { return middles[edge].error != not_shaded; }
    double length(std::uint32_t edge) const { return std::sqrt(bisection.squared_length(edge)); }
    bool can_be_split(std::uint32_t edge) const {
        const double size = length(edge);
        if (size >= usual_edge * radius) return true;
        return eye && size >= shortest_edge * radius &&
               size >= viewed_edge * double((bisection.middle(edge) - *eye).length());
    }

    /// Returns the mean tint of two vertices.
    Rgb tint(std::uint32_t a, std::uint32_t b) const {
        return tints.empty() ? Rgb(1.0f) : (tints[a] + tints[b]) * 0.5f;
    }

    /// Returns the longest edge; of equal ones that with the smallest index, so that neighbours agree.
    std::uint32_t longest_edge(std::uint32_t triangle) const {
        const auto& edges = bisection.edges_of(triangle);
        return *std::max_element(edges.begin(), edges.end(), [&](std::uint32_t a, std::uint32_t b) {
            const double length_a = bisection.squared_length(a), length_b = bisection.squared_length(b);
            return length_a != length_b ? length_a < length_b : a > b;
        });
    }
};

/// An edge of one of the instances.
struct InstanceEdge {
    std::size_t instance;
    std::uint32_t edge;
};

}  // namespace

struct MeshRefiner::State {
    State(const PointShading& shading, const RefinementSettings& wanted, std::vector<RadiantMesh> start,
          VertexMask visible)
        : shading_(shading), wanted_(wanted), solids_(shading.scene) {
        begin(std::move(start), std::move(visible));
    }

    Result<bool> step(const Progress& progress, std::size_t most_vertices) {
        compare_known();
        HF_TRY_DONE(shade_middles(new_candidates(), progress));
        std::vector<InstanceEdge> splits = best_splits(most_vertices);
        if (splits.empty() && !budget_used_up_) {
            least_gain_ = 0;
            HF_TRY_DONE(shade_middles(new_candidates(), progress));
            splits = best_splits(most_vertices);
        }
        // Shades the longer edges that must be split before the chosen ones.
        HF_TRY_DONE(shade_middles(unshaded(splits), progress));
        split(splits);
        fill_buried();
        if (progress.report) progress.report("refining", vertices_, wanted_.vertex_budget);
        ++result_.rounds;
        return !splits.empty();
    }

    Located located(const MeshPoint& at) const {
        const RefinedInstance& instance = instances_[at.instance];
        const std::array<float, 3> weights = at.weights();
        const EdgeBisection::TrianglePoint found = instance.bisection.located(
            {at.triangle, {double(weights[0]), double(weights[1]), double(weights[2])}});
        Located result{found.triangle,
                       instance.bisection.mesh().triangles[found.triangle],
                       {float(found.weights[0]), float(found.weights[1]), float(found.weights[2])}};
        bool are_shaded = true;
        for (const std::uint32_t edge : instance.bisection.edges_of(found.triangle)) {
            result.difference = std::max(result.difference, instance.middles[edge].difference);
            are_shaded = are_shaded && instance.is_shaded(edge);
        }
        if (!are_shaded)
            result.difference =
                std::max(result.difference, corner_difference(instance.radiance, result.corners) / 4);
        return result;
    }

    /// Sets Middle::known.
    void compare_known() {
        for (RefinedInstance& instance : instances_)
            for (Middle& middle : instance.middles) middle.known = 0;
        std::erase_if(known_, [&](const KnownPoint& point) {
            RefinedInstance& instance = instances_[point.at.instance];
            const Located found = located(point.at);
            Outgoing interpolated;
            Rgb tint(instance.tints.empty() ? 1.0f : 0.0f);
            for (std::size_t k = 0; k < 3; ++k) {
                interpolated += instance.radiance[found.corners[k]] * found.weights[k];
                if (!instance.tints.empty()) tint += instance.tints[found.corners[k]] * found.weights[k];
            }
            const float here = error(point.radiance, interpolated, tint);
            const std::uint32_t edge = instance.longest_edge(found.triangle);
            if (here <= known_error * tolerance_ || !instance.can_be_split(edge) ||
                instance.middles[edge].is_final)
                return true;
            instance.middles[edge].known = std::max(instance.middles[edge].known, here);
            return false;
        });
    }

    std::vector<Outgoing> fitted(const RefinedInstance& instance) const {
        const Mesh& mesh = instance.bisection.mesh();
        std::vector<std::array<Outgoing, 3>> middles(mesh.triangles.size());
        for (std::uint32_t edge = 0; edge < instance.middles.size(); ++edge) {
            const std::vector<EdgeBisection::Side> sides = instance.bisection.sides(edge);
            for (std::size_t s = 0; s < sides.size(); ++s) {
                const Outgoing middle =
                    instance.is_shaded(edge)
                        ? instance.middles[edge].radiance[s]
                        : (instance.radiance[sides[s].low] + instance.radiance[sides[s].high]) * 0.5f;
                for (const std::uint32_t t : sides[s].triangles) {
                    const auto& edges = instance.bisection.edges_of(t);
                    middles[t][std::size_t(std::ranges::find(edges, edge) - edges.begin())] = middle;
                }
            }
        }
        return fitted_radiance(mesh, instance.radiance, middles);
    }

    SceneRadiance fitted() const {
        SceneRadiance result(instances_.size());
        tbb::parallel_for(std::size_t{0}, instances_.size(),
                          [&](std::size_t i) { result[i] = fitted(instances_[i]); });
        return result;
    }

    Result<DiscontinuityMeshes> cut(std::size_t most_vertices, CutSearch extent,
                                    const Progress& progress) const {
        std::vector<UncutMesh> meshes;
        for (const RefinedInstance& instance : instances_) {
            std::vector<bool> candidates(instance.middles.size());
            for (std::size_t edge = 0; edge < candidates.size(); ++edge)
                candidates[edge] = instance.middles[edge].is_visible;
            meshes.push_back({&instance.bisection, instance.radiance, &instance.samples, instance.irradiance,
                              instance.tints, std::move(candidates)});
        }
        return DiscontinuityMeshes::make(shading_, meshes, solids_, cut_contrast * wanted_.tolerance * mean_,
                                         most_vertices, extent, progress);
    }

    Refinement finished() {
        for (RefinedInstance& instance : instances_) {
            for (const Middle& middle : instance.middles)
                result_.largest_error = std::max(result_.largest_error, middle.error);
            result_.meshes.push_back({std::move(instance.bisection).take_mesh(), std::move(instance.radiance),
                                      std::move(instance.samples)});
        }
        return std::move(result_);
    }

    Result<std::vector<Outgoing>> shaded(const std::vector<InstancePoint>& points, const Progress& progress) {
        result_.shaded_points += points.size();
        Progress silent;
        silent.stop = progress.stop;
        return point_radiance(shading_, points, silent);
    }

    void begin(std::vector<RadiantMesh> start, VertexMask visible) {
        double sum = 0;
        for (std::size_t i = 0; i < start.size(); ++i) {
            const ShadedInstance& instance = shading_.scene.instances[i];
            const float radius = shading_.scene.entities[instance.entity].occlusion->own().bounds().radius();
            // Other meshes than the fine ones have no tints.
            std::span<const Rgb> tints = shading_.scene.entities[instance.entity].tints;
            if (tints.size() != start[i].radiance.size()) tints = {};
            for (std::size_t v = 0; v < start[i].radiance.size(); ++v)
                sum += channel_sum(tinted(start[i].radiance[v], tints.empty() ? Rgb(1.0f) : tints[v]));
            vertices_ += start[i].radiance.size();
            if (visible.size() <= i) visible.emplace_back(start[i].radiance.size(), true);
            instances_.push_back({EdgeBisection(std::move(start[i].mesh)),
                                  std::move(start[i].radiance),
                                  std::move(start[i].samples),
                                  std::move(visible[i]),
                                  std::move(start[i].irradiance),
                                  {tints.begin(), tints.end()},
                                  {},
                                  instance.placement.scale,
                                  double(radius),
                                  {}});
            if (wanted_.by_view)
                instances_.back().eye = instance.placement.point_to_object(shading_.scene.eye);
            RefinedInstance& added = instances_.back();
            added.irradiance.resize(added.radiance.size());
            added.middles.resize(added.bisection.edges().size());
            for (std::uint32_t edge = 0; edge < added.middles.size(); ++edge) set_visible(added, edge);
        }
        mean_ = static_cast<float>(sum / static_cast<double>(std::max<std::size_t>(vertices_, 1)));
    }

    /// Returns the priority of a split: the error times the edge's length in the world [m], or as viewed from
    /// the eye.
    double gain(std::size_t i, std::uint32_t edge) const {
        return gain_of(i, edge, instances_[i].middles[edge].error);
    }

    double gain_of(std::size_t i, std::uint32_t edge, float error) const {
        const RefinedInstance& instance = instances_[i];
        const double gain = double(error) * instance.length(edge) * double(instance.scale) *
                            (instance.middles[edge].is_visible ? 1 : hidden_share);
        if (!wanted_.by_view) return gain;
        const Vec3f middle =
            shading_.scene.instances[i].placement.point_to_world(instance.bisection.middle(edge));
        const double distance = double((middle - shading_.scene.eye).length());
        return gain / std::max(distance, instance.length(edge) * double(instance.scale));
    }

    /// Sets Middle::is_visible.
    static void set_visible(RefinedInstance& instance, std::uint32_t edge) {
        instance.middles[edge].is_visible =
            std::ranges::any_of(instance.bisection.sides(edge), [&](const EdgeBisection::Side& side) {
                return instance.visible[side.low] && instance.visible[side.high];
            });
    }

    /// The error of a value that was found between two others, whose mean would be taken for it.
    float error(const Outgoing& found, const Outgoing& interpolated, const Rgb& tint) const {
        const Outgoing expected = tinted(interpolated, tint);
        const float size = (wanted_.is_absolute ? 0 : channel_sum(expected)) + mean_;
        return size > 0 ? channel_difference(tinted(found, tint), expected) / size : 0;
    }

    /// Returns the edges whose middles must be shaded and have not been.
    std::vector<InstanceEdge> new_candidates() const {
        std::vector<InstanceEdge> candidates;
        for (std::size_t i = 0; i < instances_.size(); ++i) {
            const RefinedInstance& instance = instances_[i];
            std::vector<bool> is_candidate(instance.middles.size());
            const Mesh& mesh = instance.bisection.mesh();
            for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                const std::uint32_t longest = instance.longest_edge(t);
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t edge = instance.bisection.edges_of(t)[k];
                    if (instance.is_shaded(edge) || is_candidate[edge]) continue;
                    const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
                    const float across =
                        error(instance.radiance[a], instance.radiance[b], instance.tint(a, b));
                    is_candidate[edge] =
                        (edge == longest || across > tolerance_) && instance.can_be_split(edge) &&
                        (instance.middles[edge].known > 0 ||
                         gain_of(i, edge, std::max(instance.middles[edge].expected, across / 2)) >=
                             least_gain_);
                    if (is_candidate[edge]) candidates.push_back({i, edge});
                }
            }
        }
        return candidates;
    }

    std::vector<InstanceEdge> unshaded(std::vector<InstanceEdge> edges) const {
        std::erase_if(edges, [&](const InstanceEdge& e) { return instances_[e.instance].is_shaded(e.edge); });
        return edges;
    }

    Result<Done> shade_middles(const std::vector<InstanceEdge>& edges, const Progress& progress) {
        struct SideMiddle {
            std::optional<SurfacePoint> point;  ///< Absent if the middle is buried.
            Outgoing interpolated;
            GatheredIrradiance irradiance;
            Rgb tint;
            float indirect_error;  ///< Middle::indirect_error
        };
        std::vector<std::vector<SideMiddle>> middles(edges.size());
        tbb::parallel_for(std::size_t{0}, edges.size(), [&](std::size_t n) {
            const auto [i, edge] = edges[n];
            const RefinedInstance& instance = instances_[i];
            const EdgeBisection& bisection = instance.bisection;
            const std::vector<Outgoing>& radiance = instance.radiance;
            const EntityOcclusion& occlusion =
                *shading_.scene.entities[shading_.scene.instances[i].entity].occlusion;
            for (const EdgeBisection::Side& side : bisection.sides(edge)) {
                std::optional<SurfacePoint> point =
                    point_on(bisection.mesh(), side.triangles, bisection.middle(edge),
                             interpolated_normal(bisection.mesh(), side, 0.5), occlusion.sampler());
                if (point && solids_.contain(shading_.scene, i, *point)) point.reset();
                GatheredIrradiance irradiance;
                const Rgb tint = instance.tint(side.low, side.high);
                float indirect_error = instance.middles[edge].indirect_error;
                if (point && shading_.indirect) {
                    const GatheredIrradiance between = mean_irradiance(instance, side);
                    if (indirect_error <= tolerance_ || varies_slowly(instance, edge, side)) {
                        irradiance = between;
                    } else {
                        irradiance = shading_.indirect->gathered_at(shading_.scene, i, *point);
                        indirect_error =
                            error_of_irradiance(i, *point, tint, irradiance.irradiance - between.irradiance);
                    }
                }
                middles[n].push_back({point, (radiance[side.low] + radiance[side.high]) * 0.5f, irradiance,
                                      tint, indirect_error});
            }
        });
        std::vector<InstancePoint> points;
        for (std::size_t n = 0; n < edges.size(); ++n)
            for (const SideMiddle& side : middles[n])
                if (side.point)
                    points.push_back({edges[n].instance, *side.point, side.irradiance.irradiance});
        HF_TRY(const std::vector<Outgoing> radiance, shaded(points, progress));
        auto next = radiance.begin();
        for (std::size_t n = 0; n < edges.size(); ++n) {
            Middle& middle = instances_[edges[n].instance].middles[edges[n].edge];
            middle.error = middle.difference = middle.indirect_error = 0;
            for (const SideMiddle& side : middles[n]) {
                middle.indirect_error = std::max(middle.indirect_error, side.indirect_error);
                middle.radiance.push_back(side.point ? *next++ : side.interpolated);
                middle.samples.points.push_back(side.point ? side.point->sample : Vec3f(0.0f));
                middle.samples.buried.push_back(!side.point);
                middle.irradiance.push_back(side.irradiance);
                middle.error =
                    std::max(middle.error, error(middle.radiance.back(), side.interpolated, side.tint));
                middle.difference = std::max(middle.difference,
                                             channel_difference(middle.radiance.back(), side.interpolated));
            }
        }
        return Done{};
    }

    static GatheredIrradiance mean_irradiance(const RefinedInstance& instance,
                                              const EdgeBisection::Side& side) {
        const GatheredIrradiance &a = instance.irradiance[side.low], &b = instance.irradiance[side.high];
        return {(a.irradiance + b.irradiance) * 0.5f, (a.nearness + b.nearness) * 0.5f};
    }

    /// Tests whether the surroundings of an edge let its irradiance vary slowly.
    static bool varies_slowly(const RefinedInstance& instance, std::uint32_t edge,
                              const EdgeBisection::Side& side) {
        const GatheredIrradiance &a = instance.irradiance[side.low], &b = instance.irradiance[side.high];
        const Mesh& mesh = instance.bisection.mesh();
        const double length = instance.length(edge) * double(instance.scale);
        const Rgb apart = a.irradiance - b.irradiance;
        const auto sum = [](const Rgb& c) { return std::abs(c.x) + std::abs(c.y) + std::abs(c.z); };
        // Infinite if the nearness of an end is unknown.
        const double nearness = double(std::max(a.nearness, b.nearness));
        return length * nearness < double(interpolated_length) &&
               mesh.normals[side.low].dot(mesh.normals[side.high]) >= least_cosine &&
               sum(apart) <= largest_difference * sum((a.irradiance + b.irradiance) * 0.5f);
    }

    /// Returns the error of radiance that an error of irradiance causes, as `error`.
    float error_of_irradiance(std::size_t i, const SurfacePoint& point, const Rgb& tint,
                              const Rgb& difference) const {
        const ShadedEntity& entity = shading_.scene.entities[shading_.scene.instances[i].entity];
        const Rgb radiance =
            entity.materials[point.material].diffuse * tint * difference * static_cast<float>(1 / pi);
        const float sum = std::abs(radiance.x) + std::abs(radiance.y) + std::abs(radiance.z);
        return mean_ > 0 ? sum / mean_ : 0;
    }

    /// The edges of this round, and with each the longer ones of its triangles that have to be split before
    /// it; as many as the budget allows.
    std::vector<InstanceEdge> best_splits(std::size_t most_vertices) {
        budget_used_up_ = false;
        std::vector<InstanceEdge> beyond;
        std::vector<double> gains;
        double largest = 0;
        for (std::size_t i = 0; i < instances_.size(); ++i)
            for (std::uint32_t edge = 0; edge < instances_[i].middles.size(); ++edge) {
                const Middle& middle = instances_[i].middles[edge];
                const bool is_known = middle.known > 0 && middle.error != not_shaded;
                if (!is_known && middle.error <= tolerance_) continue;
                beyond.push_back({i, edge});
                gains.push_back(is_known ? std::numeric_limits<double>::infinity() : gain(i, edge));
                if (!is_known) largest = std::max(largest, gains.back());
            }
        std::vector<std::size_t> order;
        for (std::size_t n = 0; n < beyond.size(); ++n)
            if (gains[n] >= 0.5 * largest) order.push_back(n);
        // The errors of parts are rarely larger than those of the whole, and the next round splits edges with
        // half of the present gain.
        least_gain_ = largest / 4;
        std::ranges::stable_sort(order, std::greater(), [&](std::size_t n) { return gains[n]; });

        std::vector<std::vector<bool>> is_chosen;
        for (const RefinedInstance& instance : instances_) is_chosen.emplace_back(instance.middles.size());
        std::vector<InstanceEdge> chosen;
        std::size_t vertices = vertices_;
        for (const std::size_t n : order) {
            const InstanceEdge& largest_left = beyond[n];
            const std::size_t i = largest_left.instance;
            const RefinedInstance& instance = instances_[i];
            const std::size_t before = chosen.size();
            std::size_t added = 0;
            const auto choose = [&](std::uint32_t e) {
                if (is_chosen[i][e]) return;
                is_chosen[i][e] = true;
                chosen.push_back({i, e});
                added += instance.bisection.sides(e).size();
            };
            choose(largest_left.edge);
            for (std::size_t next = before; next < chosen.size(); ++next)
                for (const std::uint32_t t : instance.bisection.edges()[chosen[next].edge].triangles)
                    choose(instance.longest_edge(t));
            if (vertices + added > wanted_.vertex_budget) {
                chosen.resize(before);
                budget_used_up_ = true;
                break;
            }
            vertices += added;
            if (vertices >= most_vertices) break;
        }
        return chosen;
    }

    /// Splits the edges, the longest first.
    void split(std::vector<InstanceEdge> edges) {
        std::stable_sort(edges.begin(), edges.end(), [&](const InstanceEdge& a, const InstanceEdge& b) {
            const double length_a = instances_[a.instance].bisection.squared_length(a.edge),
                         length_b = instances_[b.instance].bisection.squared_length(b.edge);
            return length_a != length_b ? length_a > length_b
                                        : std::tie(a.instance, a.edge) < std::tie(b.instance, b.edge);
        });
        for (const auto [i, edge] : edges) {
            RefinedInstance& instance = instances_[i];
            std::vector<std::uint8_t> are_visible;
            std::vector<Rgb> tints;
            for (const EdgeBisection::Side& side : instance.bisection.sides(edge)) {
                are_visible.push_back(instance.visible[side.low] && instance.visible[side.high]);
                if (!instance.tints.empty()) tints.push_back(instance.tint(side.low, side.high));
            }
            float expected = 0, indirect_error = 0;
            for (const std::uint32_t t : instance.bisection.edges()[edge].triangles)
                for (const std::uint32_t e : instance.bisection.edges_of(t)) {
                    const Middle& middle = instance.middles[e];
                    expected = std::max(expected, instance.is_shaded(e) ? middle.error : middle.expected);
                    indirect_error = std::max(indirect_error, middle.indirect_error);
                }
            if (!instance.bisection.split(edge)) {
                instance.middles[edge].error = 0;
                instance.middles[edge].is_final = true;
                continue;
            }
            const std::size_t before = instance.middles.size();
            const Middle middle = std::exchange(instance.middles[edge], {});
            const auto append = [](auto& to, const auto& from) {
                to.insert(to.end(), from.begin(), from.end());
            };
            append(instance.radiance, middle.radiance);
            append(instance.samples.points, middle.samples.points);
            append(instance.samples.buried, middle.samples.buried);
            append(instance.visible, are_visible);
            append(instance.tints, tints);
            append(instance.irradiance, middle.irradiance);
            instance.middles.resize(instance.bisection.edges().size());
            const auto begin_edge = [&](std::uint32_t e) {
                instance.middles[e].expected = expected;
                instance.middles[e].indirect_error = indirect_error;
                set_visible(instance, e);
            };
            begin_edge(edge);
            for (std::size_t e = before; e < instance.middles.size(); ++e)
                begin_edge(static_cast<std::uint32_t>(e));
            vertices_ += middle.radiance.size();
        }
    }

    /// Fills the buried vertices again, because splits may have added nearer neighbours.
    void fill_buried() {
        tbb::parallel_for(std::size_t{0}, instances_.size(), [&](std::size_t i) {
            RefinedInstance& instance = instances_[i];
            BuriedFill(instance.bisection.mesh(), instance.samples.buried)(instance.radiance);
        });
    }

    const PointShading shading_;
    const RefinementSettings wanted_;
    float tolerance_ = wanted_.tolerance;
    const PlacedSolids solids_;
    std::vector<RefinedInstance> instances_;
    std::size_t vertices_ = 0;
    bool budget_used_up_ = false;
    double least_gain_ = 0;  ///< Middles with a smaller expected gain are not shaded yet.
    float mean_ = 0;         ///< Radiance of the vertices at the start, added over the channels.
    std::vector<KnownPoint> known_;
    Refinement result_;
};

MeshRefiner::MeshRefiner(const PointShading& shading, const RefinementSettings& settings,
                         std::vector<RadiantMesh> start, VertexMask visible)
    : state_(std::make_unique<State>(shading, settings, std::move(start), std::move(visible))) {}
MeshRefiner::~MeshRefiner() = default;

Result<bool> MeshRefiner::step(const Progress& progress, std::size_t most_vertices) {
    return state_->step(progress, most_vertices);
}
void MeshRefiner::set_tolerance(float tolerance) {
    state_->tolerance_ = tolerance;
}
void MeshRefiner::add_known(std::span<const KnownPoint> points) {
    state_->known_.insert(state_->known_.end(), points.begin(), points.end());
}
std::size_t MeshRefiner::vertices() const {
    return state_->vertices_;
}
bool MeshRefiner::is_budget_used_up() const {
    return state_->budget_used_up_;
}
MeshRefiner::Located MeshRefiner::located(const MeshPoint& at_start) const {
    return state_->located(at_start);
}
std::span<const Outgoing> MeshRefiner::radiance(std::size_t instance) const {
    return state_->instances_[instance].radiance;
}
SceneRadiance MeshRefiner::fitted() const {
    return state_->fitted();
}
Result<DiscontinuityMeshes> MeshRefiner::cut(std::size_t most_vertices, CutSearch extent,
                                             const Progress& progress) const {
    return state_->cut(most_vertices, extent, progress);
}
Refinement MeshRefiner::finished() && {
    return state_->finished();
}

Result<Refinement> refined_radiance(const PointShading& shading, const RefinementSettings& refinement,
                                    std::vector<RadiantMesh> start, const Progress& progress) {
    MeshRefiner refiner(shading, refinement, std::move(start));
    for (;;) {
        HF_TRY(const bool is_split, refiner.step(progress));
        if (!is_split) return std::move(refiner).finished();
    }
}

}  // namespace haarfield
