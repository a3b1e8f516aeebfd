#include "shading/bake/bake_error.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "fields/base/parallel_loop.h"
#include "shading/bake/bounced_radiance.h"
#include "shading/bake/scrambled_sobol.h"
#include "shading/visibility/placed_solids.h"

namespace haarfield {
namespace {

constexpr std::size_t steering_points = 2048, shading_points = 512, path_points = 128;
constexpr std::size_t resamplings = 200;
constexpr double interval = 0.9;

/// Returns a whole number below `count`, the same on every platform.
std::size_t number_below(std::mt19937& random, std::size_t count) {
    return std::size_t((std::uint64_t(random()) * count) >> 32);
}

double channel_sum(const Rgb& colour) {
    return double(colour.x) + double(colour.y) + double(colour.z);
}

double square_of(const Vec3d& colour) {
    return colour.dot(colour);
}

Vec3d displayed(const Outgoing& radiance, const DisplayedPoint& point) {
    return Vec3d(radiance.diffuse * point.diffuse + radiance.specular * point.specular);
}

/// Values of a stratum: their mean counts by `weight`.
struct Stratum {
    double weight = 0;
    std::vector<double> values;
};

/// Returns the weighted mean, and those of bootstrap samples.
SquareEstimate estimate(const std::vector<Stratum>& strata, double scale) {
    SquareEstimate result;
    const auto add = [&](const Stratum& stratum, double sum, double& to) {
        if (!stratum.values.empty()) to += scale * stratum.weight * sum / double(stratum.values.size());
    };
    for (const Stratum& stratum : strata)
        add(stratum, std::accumulate(stratum.values.begin(), stratum.values.end(), 0.0), result.square);
    std::mt19937 random(2006);
    for (std::size_t k = 0; k < resamplings; ++k) {
        double& square = result.resampled.emplace_back(0);
        for (const Stratum& stratum : strata) {
            double sum = 0;
            for (std::size_t i = 0; i < stratum.values.size(); ++i)
                sum += stratum.values[number_below(random, stratum.values.size())];
            add(stratum, sum, square);
        }
    }
    return result;
}

double root(double square) {
    return std::sqrt(std::max(0.0, square));
}

/// A point that can be shaded, and what it displays.
struct ShadedPoint {
    DisplayedPoint displayed;
    InstancePoint at;
    Vec3f place;  ///< In the world. [m]
    Outgoing direct, indirect;

    Outgoing radiance() const { return direct + indirect; }
};

}  // namespace

struct BakeErrorMeter::State {
    State(const PointShading& of, std::vector<DisplayedPoint> all)
        : shading(of), population(std::move(all)), solids(of.scene) {}

    std::optional<ShadedPoint> point(std::size_t number) const {
        const DisplayedPoint& displayed = population[number];
        const ShadedInstance& instance = shading.scene.instances[displayed.at.instance];
        const std::optional<SurfacePoint> found =
            surface_point(shading.scene.entities[instance.entity], displayed.at);
        if (!found || solids.contain(shading.scene, displayed.at.instance, *found)) return std::nullopt;
        return ShadedPoint{displayed,
                           {displayed.at.instance, *found},
                           instance.placement.point_to_world(found->position),
                           {},
                           {}};
    }

    /// Returns the points of the population that are not buried, shaded by the bake's method, in the given
    /// order.
    Result<std::vector<ShadedPoint>> shaded(std::span<const std::size_t> numbers,
                                            const Progress& progress) const {
        std::vector<ShadedPoint> points;
        for (const std::size_t number : numbers)
            if (std::optional<ShadedPoint> found = point(number)) points.push_back(*found);
        std::vector<Vec3f> places;
        for (const ShadedPoint& each : points) places.push_back(each.place);
        const std::vector<std::uint32_t> order = spatial_order(places);
        std::vector<InstancePoint> ordered;
        for (const std::uint32_t k : order) ordered.push_back(points[k].at);
        PointShading direct = shading;
        direct.indirect = nullptr;
        direct.sharing = nullptr;
        Progress silent;
        silent.stop = progress.stop;
        const Result<std::vector<Outgoing>> radiance = point_radiance(direct, ordered, silent);
        if (!radiance) return radiance.error();
        for (std::size_t k = 0; k < order.size(); ++k) points[order[k]].direct = (*radiance)[k];
        if (!shading.indirect) return points;
        const Result<std::vector<Outgoing>> indirect = indirect_radiance(shading, ordered, silent);
        if (!indirect) return indirect.error();
        for (std::size_t k = 0; k < order.size(); ++k) points[order[k]].indirect = (*indirect)[k];
        return points;
    }

    /// Returns random numbers of points, with repetition.
    std::vector<std::size_t> chosen(std::size_t count, std::uint32_t seed) const {
        std::mt19937 random(seed);
        std::vector<std::size_t> numbers;
        for (std::size_t k = 0; k < count && !population.empty(); ++k)
            numbers.push_back(number_below(random, population.size()));
        return numbers;
    }

    /// Shades the points that steer a refinement, once.
    Result<Done> prepare(const Progress& progress) {
        if (!steering.empty() || population.empty()) return Done{};
        Result<std::vector<ShadedPoint>> points = shaded(chosen(steering_points, 1), progress);
        if (!points) return points.error();
        steering = std::move(*points);
        double sum = 0;
        for (const ShadedPoint& each : steering) sum += square_of(displayed(each.radiance(), each.displayed));
        mean_square = steering.empty() ? 0 : sum / double(steering.size());
        return Done{};
    }

    double scale() const { return mean_square > 0 ? 1 / mean_square : 0; }

    /// Not a reference: frames of sessions replace their shading.
    const PointShading shading;
    const std::vector<DisplayedPoint> population;
    const PlacedSolids solids;
    std::vector<ShadedPoint> steering;
    double mean_square = 0;  ///< Of the displayed radiance.
};

BakeErrorMeter::BakeErrorMeter(const PointShading& shading, std::vector<DisplayedPoint> population)
    : state_(std::make_unique<State>(shading, std::move(population))) {}
BakeErrorMeter::~BakeErrorMeter() = default;

Result<BakeErrorMeter::Shading> BakeErrorMeter::shading_error(double accuracy, const Progress& progress) {
    HF_TRY_DONE(state_->prepare(progress));
    const Result<std::vector<ShadedPoint>> points =
        state_->shaded(state_->chosen(shading_points, 2), progress);
    if (!points) return points.error();
    const PointShading& shading = state_->shading;
    const RayScene rays(shading.scene);
    std::optional<PathTracer> paths;
    if (shading.indirect)
        paths.emplace(shading.scene, *shading.indirect->surface, shading.geometry.rays,
                      shading.settings.sources);
    // The noise of a mean square falls with the number of samples.
    const double effort = std::clamp(1e-4 / (accuracy * accuracy), 0.25, 16.0);
    const auto samples = std::uint32_t(1024 * effort), traced = std::uint32_t(512 * effort);
    Shading result;
    result.references.resize(points->size());
    const Result<Done> measured = parallel_loop(
        {points->size()},
        [&]() -> LoopBody {
            return [&](std::size_t k) {
                const ShadedPoint& point = (*points)[k];
                const ShadedInstance& instance = shading.scene.instances[point.at.instance];
                const SurfacePoint& at = point.at.point;
                Reference& reference = result.references[k];
                reference.point = point.displayed;
                reference.shaded = displayed(point.radiance(), point.displayed);
                reference.has_indirect = paths && k < path_points;
                std::array<Vec3d, 2> direct, indirect;
                for (std::uint32_t r = 0; r < 2; ++r) {
                    const std::uint32_t seed = mixed_seed(std::uint32_t(k), r);
                    direct[r] =
                        displayed(point.direct, point.displayed) -
                        displayed(ray_radiance(rays, point.at.instance, at, samples, seed), point.displayed);
                    if (!reference.has_indirect) continue;
                    const ShadingPoint seen = shading_point(shading.scene, instance, at);
                    indirect[r] = displayed(point.indirect, point.displayed) -
                                  displayed(paths->indirect_radiance(seen.from, seen.brdf, traced, seed),
                                            point.displayed);
                }
                reference.direct_product = direct[0].dot(direct[1]);
                reference.direct = (direct[0] + direct[1]) * 0.5;
                if (!reference.has_indirect) return;
                reference.indirect_product = indirect[0].dot(indirect[1]);
                reference.mixed_product = direct[0].dot(indirect[1]) + direct[1].dot(indirect[0]);
                reference.indirect = (indirect[0] + indirect[1]) * 0.5;
            };
        },
        "reference points", progress);
    if (!measured) return measured.error();
    Stratum direct{1, {}}, indirect{1, {}}, both{1, {}};
    for (const Reference& reference : result.references) {
        direct.values.push_back(reference.direct_product);
        if (!reference.has_indirect) continue;
        indirect.values.push_back(reference.indirect_product);
        both.values.push_back(reference.indirect_product + reference.mixed_product);
    }
    result.direct = estimate({direct}, state_->scale());
    result.indirect = estimate({indirect}, state_->scale());
    result.all = estimate({direct, both}, state_->scale());
    return result;
}

Result<SquareEstimate> BakeErrorMeter::steering_error(const DisplayedRadiance& bake,
                                                      const Progress& progress) {
    HF_TRY_DONE(state_->prepare(progress));
    Stratum stratum{1, {}};
    for (const ShadedPoint& point : state_->steering)
        stratum.values.push_back(square_of(displayed(bake(point.displayed.at).radiance, point.displayed) -
                                           displayed(point.radiance(), point.displayed)));
    return estimate({stratum}, state_->scale());
}

Result<BakeErrorMeter::Interpolation> BakeErrorMeter::interpolation_error(const DisplayedRadiance& bake,
                                                                          std::uint32_t seed,
                                                                          std::size_t count,
                                                                          const Progress& progress) {
    HF_TRY_DONE(state_->prepare(progress));
    // Octaves of the expected error, from a 64th of the RMS radiance on.
    constexpr std::size_t octaves = 10;
    const std::vector<DisplayedPoint>& population = state_->population;
    std::vector<std::uint8_t> octave(population.size());
    const double unit = 3 * root(state_->mean_square / 3) / 64;
    tbb::parallel_for(std::size_t(0), population.size(), [&](std::size_t k) {
        const DisplayedPoint& point = population[k];
        const double expected = double(bake(point.at).difference) *
                                (channel_sum(point.diffuse) + channel_sum(point.specular)) / 6;
        const double above = unit > 0 ? std::log2(std::max(1e-30, expected / unit)) : 0;
        octave[k] = std::uint8_t(std::clamp(above + 1, 0.0, double(octaves - 1)));
    });
    std::array<std::vector<std::size_t>, octaves> members;
    for (std::size_t k = 0; k < population.size(); ++k) members[octave[k]].push_back(k);
    // Neyman: in proportion to the deviation of the squared error, that is to the squared expectation; half
    // of the points in proportion to size, for errors that nothing foretells.
    std::array<double, octaves> wanted{};
    double all = 0;
    for (std::size_t s = 0; s < octaves; ++s) {
        wanted[s] = double(members[s].size()) * std::exp2(2 * double(s));
        all += wanted[s];
    }
    std::mt19937 random(mixed_seed(3, seed));
    std::vector<std::size_t> numbers;
    std::vector<std::size_t> stratum_of;
    for (std::size_t s = 0; s < octaves; ++s) {
        if (members[s].empty()) continue;
        const double share =
            0.5 * wanted[s] / all + 0.5 * double(members[s].size()) / double(population.size());
        const std::size_t points =
            std::min(members[s].size(), std::max<std::size_t>(16, std::size_t(share * double(count))));
        for (std::size_t k = 0; k < points; ++k) {
            std::swap(members[s][k], members[s][k + number_below(random, members[s].size() - k)]);
            if (!state_->point(members[s][k])) continue;
            numbers.push_back(members[s][k]);
            stratum_of.push_back(s);
        }
    }
    const Result<std::vector<ShadedPoint>> points = state_->shaded(numbers, progress);
    if (!points) return points.error();
    std::vector<Stratum> strata(octaves);
    for (std::size_t s = 0; s < octaves; ++s)
        strata[s].weight = double(members[s].size()) / double(population.size());
    Interpolation result;
    result.points = points->size();
    for (std::size_t k = 0; k < points->size(); ++k) {
        const ShadedPoint& point = (*points)[k];
        const double square = square_of(displayed(bake(point.displayed.at).radiance, point.displayed) -
                                        displayed(point.radiance(), point.displayed));
        strata[stratum_of[k]].values.push_back(square);
        const double error = root(square * state_->scale());
        if (error > result.worst.error) result.worst = {point.displayed, error, true};
    }
    result.square = estimate(strata, state_->scale());
    return result;
}

BakeError BakeErrorMeter::error(const DisplayedRadiance& bake, const Interpolation& between,
                                const Shading& shading) const {
    BakeError error;
    error.between = root(between.square.square);
    error.at_vertices = root(shading.direct.square);
    error.indirect = root(shading.indirect.square);
    error.points = between.points;
    error.references = shading.references.size();
    error.worst = between.worst;
    // What references say, with the products of both summands of the error.
    Stratum direct{1, {}}, indirect{1, {}};
    for (const Reference& reference : shading.references) {
        const Vec3d off = displayed(bake(reference.point.at).radiance, reference.point) - reference.shaded;
        direct.values.push_back(reference.direct_product + 2 * off.dot(reference.direct));
        if (reference.has_indirect)
            indirect.values.push_back(reference.indirect_product + reference.mixed_product +
                                      2 * off.dot(reference.indirect));
        const double here = root(square_of(off + reference.direct + reference.indirect) * state_->scale());
        if (here > error.worst.error) error.worst = {reference.point, here, false};
    }
    const SquareEstimate others = estimate({direct, indirect}, state_->scale());
    // Too few references have large errors to show that both summands cancel by more than a half.
    const auto sum = [](double square, double other) {
        return root(square + std::max(other, -0.5 * square));
    };
    error.total = sum(between.square.square, others.square);
    std::vector<double> totals;
    for (std::size_t k = 0; k < between.square.resampled.size(); ++k)
        totals.push_back(sum(between.square.resampled[k], others.resampled[k]));
    std::ranges::sort(totals);
    if (totals.empty()) return error;
    const auto at = [&](double share) {
        return totals[std::min(totals.size() - 1, std::size_t(share * double(totals.size())))];
    };
    error.low = at((1 - interval) / 2);
    error.high = at((1 + interval) / 2);
    return error;
}

std::vector<DisplayedPoint> area_points(const ShadedScene& scene, std::size_t count) {
    struct Range {
        std::uint32_t instance, triangle;
        double end;  ///< Area up to and with this triangle. [m^2]
    };
    std::vector<Range> ranges;
    double area = 0;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        const Mesh& mesh = *entity.mesh;
        const double scale = double(scene.instances[i].placement.scale);
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            const std::vector<std::uint8_t>& buried = entity.occlusion->samples().buried;
            if (buried[a] || buried[b] || buried[c]) continue;
            const Vec3d from(mesh.positions[a]);
            area += 0.5 * scale * scale *
                    (Vec3d(mesh.positions[b]) - from).cross(Vec3d(mesh.positions[c]) - from).length();
            ranges.push_back({i, t, area});
        }
    }
    std::vector<DisplayedPoint> points;
    const ScrambledSobol places(2006);
    auto range = ranges.begin();
    for (std::size_t k = 0; k < count && area > 0; ++k) {
        const double below = area * (double(k) + 0.5) / double(count);
        while (range + 1 != ranges.end() && range->end < below) ++range;
        auto [u, v] = places(std::uint32_t(k));
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        points.push_back(
            {{range->instance, range->triangle, float(u), float(v)}, Rgb(1.0f), Rgb(1.0f), std::uint32_t(k)});
    }
    return points;
}

}  // namespace haarfield
