#include "shading/bake/bake_error.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "fields/base/parallel_loop.h"
#include "shading/bake/bounced_radiance.h"
#include "shading/bake/path_tracer.h"
#include "shading/bake/ray_renderer.h"
#include "shading/bake/scrambled_sobol.h"
#include "shading/visibility/placed_solids.h"

namespace haarfield {
namespace {

constexpr std::size_t steering_points = 2048, path_points = 128, focus_points = 512;
constexpr std::size_t resamplings = 200;
/// The largest ratio of the deviations of an estimate and of a resampled one.
constexpr double largest_ratio = 4;
/// The largest number of points that measure the RMS radiance, and the samples of each of the two estimates
/// at a point.
constexpr std::size_t scale_points = 131072;
constexpr std::uint32_t scale_samples = 4, scale_sets = 4096;
/// Paths of a point: of each of the pilot estimates, and of a reference.
constexpr std::uint32_t pilot_estimates = 4, pilot_samples = 32, least_path_samples = 32,
                        most_path_samples = 65536;
/// The most paths of each of two references of all points.
constexpr double most_paths = 1 << 21;
/// The error that the noise of all paths adds to a bake without errors, relative to the wanted accuracy.
constexpr double path_noise_share = 0.3;
constexpr double interval = 0.9;
/// Samples of all sets of direct light, and limits of the number of sets.
constexpr std::uint32_t direct_set_samples = 1u << 18, fewest_sets = 16, most_sets = 128;
/// The most samples of a reference of direct light.
constexpr std::uint32_t most_direct_samples = 1u << 16;

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

/// Returns the unbiased variance of independent estimates, the sum over the channels.
double variance_of(std::span<const Vec3d> estimates) {
    Vec3d mean(0.0);
    for (const Vec3d& each : estimates) mean += each / double(estimates.size());
    double sum = 0;
    for (const Vec3d& each : estimates) sum += square_of(each - mean);
    return sum / double(estimates.size() - 1);
}

/// Values whose mean counts by `weight`.
struct WeightedValues {
    double weight = 0;
    std::vector<double> values;
    /// The share of the stratum's members that `values` has: the mean of a whole stratum is exact.
    double share = 0;
};

/// A mean of drawn values, and its variance.
struct DrawnMean {
    double mean = 0, variance = 0;
};

/// value  (std::size_t number) -> double, called once for each of `count` numbers.
template <class Value>
DrawnMean drawn_mean(std::size_t count, const Value& value) {
    if (count == 0) return {};
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double each = value(i);
        sum += each;
        squares += each * each;
    }
    const double mean = sum / double(count);
    return {mean, std::max(0.0, squares / double(count) - mean * mean) / double(count)};
}

DrawnMean mean_of(const std::vector<double>& values) {
    return drawn_mean(values.size(), [&](std::size_t i) { return values[i]; });
}

double weighted_mean(const std::vector<WeightedValues>& strata) {
    double mean = 0;
    for (const WeightedValues& stratum : strata) mean += stratum.weight * mean_of(stratum.values).mean;
    return mean;
}

/// Returns the weighted mean, and estimates that deviate from it by its uncertainty. They are those of
/// bootstrap-t: means of bootstrap samples alone deviate too little upwards if few values are large.
SquareEstimate estimate(const std::vector<WeightedValues>& strata, double scale) {
    SquareEstimate result;
    std::vector<DrawnMean> drawn;
    double variance = 0;
    for (const WeightedValues& stratum : strata) {
        drawn.push_back(mean_of(stratum.values));
        result.square += scale * stratum.weight * drawn.back().mean;
        variance += std::pow(scale * stratum.weight, 2) * (1 - stratum.share) * drawn.back().variance;
    }
    std::mt19937 random(2006);
    for (std::size_t k = 0; k < resamplings; ++k) {
        double off = 0, resampled_variance = 0;
        for (std::size_t s = 0; s < strata.size(); ++s) {
            const WeightedValues& stratum = strata[s];
            const DrawnMean resampled = drawn_mean(stratum.values.size(), [&](std::size_t) {
                return stratum.values[number_below(random, stratum.values.size())];
            });
            // The correction for finite populations: a stratum that was drawn as a whole adds no deviation.
            off += scale * stratum.weight * std::sqrt(1 - stratum.share) * (resampled.mean - drawn[s].mean);
            resampled_variance +=
                std::pow(scale * stratum.weight, 2) * (1 - stratum.share) * resampled.variance;
        }
        const double ratio =
            resampled_variance > 0 ? std::sqrt(variance / resampled_variance) : largest_ratio;
        result.resampled.push_back(result.square - off * std::clamp(ratio, 1 / largest_ratio, largest_ratio));
    }
    return result;
}

double root(double square) {
    return std::sqrt(std::max(0.0, square));
}

/// Two independent estimates by point.
using Pairs = std::vector<std::array<Vec3d, 2>>;

/// Estimates the deviation of the weighted sum of the products of both estimates, if their mean is small.
double product_deviation(const Pairs& estimates, std::span<const double> weights) {
    double sum = 0;
    for (std::size_t k = 0; k < estimates.size(); ++k)
        sum += std::pow(weights[k] * square_of(estimates[k][0] - estimates[k][1]) / 2, 2);
    return std::sqrt(sum / 3);  // 3: of the fourth power of a normal variable
}

/// The numbers of paths of references.
struct PathCounts {
    std::vector<std::uint32_t> by_point;
    bool are_limited = false;  ///< True: fewer than are needed.
};

/// Chooses few paths for a wanted deviation of the weighted sum of the products of two estimates, that is the
/// root of the sum of (weight * variance / paths)^2.
///
/// variances  of one path, by point.
PathCounts path_counts(std::span<const double> variances, std::span<const double> weights, double wanted) {
    double mean = 0, all = 0, sum = 0;
    for (std::size_t k = 0; k < variances.size(); ++k) {
        mean += weights[k] * variances[k];
        all += weights[k];
    }
    std::vector<double> shares;
    for (std::size_t k = 0; k < variances.size(); ++k) {
        // A pilot can miss the rare bright paths that pilots of other points found.
        const double variance = std::max(variances[k], mean / all / 2);
        sum += shares.emplace_back(std::cbrt(std::pow(weights[k] * variance, 2)));
    }
    PathCounts counts;
    double factor = wanted > 0 ? std::sqrt(sum) / wanted : 0;
    const double largest = sum > 0 ? most_paths / sum : 0;
    counts.are_limited = !(wanted > 0 && factor < largest);
    factor = std::min(factor, largest);
    for (const double share : shares)
        // Powers of two, for which Sobol points are well distributed.
        counts.by_point.push_back(std::bit_ceil(std::uint32_t(
            std::clamp(factor * share, double(least_path_samples), double(most_path_samples)))));
    return counts;
}

/// A point that can be shaded, and what it displays.
struct ShadedPoint {
    DisplayedPoint displayed;
    InstancePoint at;
    Vec3f place;  ///< In the world. [m]
    Outgoing direct, indirect;

    Outgoing radiance() const { return direct + indirect; }
    Vec3d displayed_radiance() const { return displayed.displayed(radiance()); }
};

/// Points of strata of a population.
struct StratifiedPoints {
    std::vector<ShadedPoint> points;
    std::vector<std::size_t> stratum;  ///< By point.
    std::vector<double> weights;       ///< By stratum: its share of the population.
    std::vector<double> shares;        ///< By stratum: WeightedValues::share.
};

}  // namespace

/// The points, and the references of their direct light, which all shadings of a scene share.
struct BakeErrorMeter::Truth {
    Truth(const ShadedScene& scene, std::vector<DisplayedPoint> all)
        : population(std::move(all)), solids(scene) {}

    /// Two independent references of direct light.
    using DirectPair = std::array<Outgoing, 2>;

    /// Two independent references of indirect light.
    struct PathPair {
        double variance = 0;        ///< Of one path. [(W/(m^2 sr))^2]
        std::uint32_t samples = 0;  ///< Of each reference; 0: the references are not set.
        std::array<Vec3d, 2> displayed;
    };

    const std::vector<DisplayedPoint> population;
    const PlacedSolids solids;
    std::optional<RayScene> rays;  ///< Once it is needed.
    std::optional<DirectRays> direct_rays;
    std::uint32_t direct_samples = 0;               ///< Of direct_rays; never fewer than before.
    std::vector<DirectPair> of_shading_points;      ///< Of the first points of shading_error, by direct_rays.
    std::vector<PathPair> paths_of_shading_points;  ///< Of its first points.
    std::optional<double> direct_square;  ///< The mean square of the direct light, once it is needed.
};

struct BakeErrorMeter::State {
    State(const PointShading& of, std::shared_ptr<Truth> shared)
        : shading(of), truth(std::move(shared)), population(truth->population) {}

    std::optional<ShadedPoint> point(std::size_t number) const {
        const DisplayedPoint& displayed = population[number];
        const ShadedInstance& instance = shading.scene.instances[displayed.at.instance];
        const std::optional<SurfacePoint> found =
            surface_point(shading.scene.entities[instance.entity], displayed.at);
        if (!found || truth->solids.contain(shading.scene, displayed.at.instance, *found))
            return std::nullopt;
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
        HF_TRY(const std::vector<Outgoing> radiance, point_radiance(direct, ordered, silent));
        for (std::size_t k = 0; k < order.size(); ++k) points[order[k]].direct = radiance[k];
        if (!shading.indirect) return points;
        HF_TRY(const std::vector<Outgoing> indirect, indirect_radiance(shading, ordered, silent));
        for (std::size_t k = 0; k < order.size(); ++k) points[order[k]].indirect = indirect[k];
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

    /// Measures the RMS radiance, once. Only indirect light needs the points that steer a refinement.
    Result<Done> prepare_scale(const Progress& progress) {
        if (shading.indirect || population.empty()) return prepare(progress);
        HF_TRY_DONE(measure_direct_square(progress));
        mean_square = *truth->direct_square;
        return Done{};
    }

    /// Shades the points that steer a refinement, once.
    Result<Done> prepare(const Progress& progress) {
        if (!steering.points.empty() || population.empty()) return Done{};
        HF_TRY_DONE(measure_direct_square(progress));
        HF_TRY(steering.points, shaded(chosen(steering_points, 1), progress));
        steering.stratum.assign(steering.points.size(), 0);
        double indirect = 0;  // with its product with direct light
        for (const ShadedPoint& each : steering.points)
            indirect +=
                square_of(each.displayed_radiance()) - square_of(each.displayed.displayed(each.direct));
        mean_square = *truth->direct_square;
        if (!steering.points.empty()) mean_square += indirect / double(steering.points.size());
        return Done{};
    }

    /// Measures the mean square of the direct light by few rays at many points: a few highlights may
    /// contribute most of it.
    Result<Done> measure_direct_square(const Progress& progress) const {
        if (truth->direct_square) return Done{};
        prepare_rays();
        const DirectRays rays(*truth->rays, scale_samples, scale_sets);
        const std::size_t count = std::min(scale_points, population.size());
        std::vector<std::optional<double>> squares(count);  // none: buried
        HF_TRY_DONE(parallel_loop(
            {count},
            [&]() -> LoopBody {
                return [&](std::size_t k) {
                    const std::optional<ShadedPoint> found = point(k * population.size() / count);
                    if (!found) return;
                    std::array<Vec3d, 2> estimates;
                    for (std::uint32_t r = 0; r < 2; ++r)
                        estimates[r] = found->displayed.displayed(
                            direct_reference(rays, found->at, 2 * mixed_seed(5, std::uint32_t(k)) + r));
                    squares[k] = estimates[0].dot(estimates[1]);
                };
            },
            "reference points", progress));
        double sum = 0, shown = 0;
        for (const std::optional<double>& square : squares) {
            sum += square.value_or(0);
            shown += square.has_value();
        }
        truth->direct_square = sum / std::max(1.0, shown);
        return Done{};
    }

    /// Returns the direct light of a point by the samples of a set.
    Outgoing direct_reference(const DirectRays& rays, const InstancePoint& point, std::uint32_t set) const {
        const ShadedInstance& placed = shading.scene.instances[point.instance];
        return rays.radiance(point.instance, shading_point(shading.scene, placed, point.point),
                             shading.scene.entities[placed.entity].materials[point.point.material], set);
    }

    /// Prepares the rays of references, once.
    void prepare_rays() const {
        if (truth->rays) return;
        truth->rays.emplace(shading.scene);
        std::vector<SurfacePlace> places;
        const std::size_t count = std::min(focus_points, population.size());
        for (std::size_t k = 0; k < count; ++k)
            if (const std::optional<ShadedPoint> found = point(k * population.size() / count)) {
                const ShadingPoint at = shading_point(
                    shading.scene, shading.scene.instances[found->at.instance], found->at.point);
                places.push_back({at.from, at.brdf.normal});
            }
        truth->rays->focus(places);
    }

    /// Sets the number of samples of references, if it is larger than before.
    void set_direct_samples(std::uint32_t samples) {
        prepare_rays();
        if (truth->direct_samples >= samples) return;
        truth->direct_rays.emplace(*truth->rays, samples,
                                   std::clamp(direct_set_samples / samples, fewest_sets, most_sets));
        truth->direct_samples = samples;
        truth->of_shading_points.clear();
    }

    /// Compares the direct light of points with two references of each, which have as many samples as their
    /// noise requires.
    ///
    /// known  as for `references`.
    Result<Pairs> direct_errors(std::span<const ShadedPoint> points, double accuracy,
                                std::vector<Truth::DirectPair>& known, const Progress& progress) {
        const std::vector<double> weights(points.size(), 1 / double(std::max<std::size_t>(1, points.size())));
        const double wanted = std::pow(path_noise_share * accuracy, 2) * mean_square;
        for (;;) {
            HF_TRY_DONE(add_direct(points, accuracy, known, progress));
            Pairs errors(points.size());
            for (std::size_t k = 0; k < points.size(); ++k)
                for (std::size_t r = 0; r < 2; ++r)
                    errors[k][r] = points[k].displayed.displayed(points[k].direct) -
                                   points[k].displayed.displayed(known[k][r]);
            const std::uint32_t samples = truth->direct_samples;
            if (samples >= most_direct_samples || product_deviation(errors, weights) <= 2 * wanted)
                return errors;
            known.clear();
            set_direct_samples(std::min(4 * samples, most_direct_samples));
        }
    }

    /// Adds the references of direct light of the points that have none.
    Result<Done> add_direct(std::span<const ShadedPoint> points, double accuracy,
                            std::vector<Truth::DirectPair>& known, const Progress& progress) {
        // The noise of a mean square falls with the number of samples.
        const double effort = std::clamp(1e-4 / (accuracy * accuracy), 0.25, 16.0);
        set_direct_samples(std::uint32_t(1024 * effort));
        const std::size_t first = known.size();
        if (first >= points.size()) return Done{};
        std::vector<Truth::DirectPair> added(points.size() - first);
        HF_TRY_DONE(parallel_loop(
            {added.size()},
            [&]() -> LoopBody {
                return [&](std::size_t n) {
                    const std::size_t k = first + n;
                    for (std::uint32_t r = 0; r < 2; ++r)
                        added[n][r] =
                            direct_reference(*truth->direct_rays, points[k].at, 2 * std::uint32_t(k) + r);
                };
            },
            "reference points", progress));
        known.insert(known.end(), added.begin(), added.end());
        return Done{};
    }

    /// Compares shaded points with references.
    ///
    /// known           references of direct light of the first points; those of the others are added.
    /// known_paths     likewise, of indirect light.
    /// traced_weights  the weights of the first points in the mean over the population; the indirect light
    ///                 of these is compared.
    Result<std::vector<Reference>> references(std::span<const ShadedPoint> points, double accuracy,
                                              std::vector<Truth::DirectPair>& known,
                                              std::vector<Truth::PathPair>& known_paths,
                                              std::span<const double> traced_weights,
                                              const Progress& progress) {
        HF_TRY(const Pairs direct, direct_errors(points, accuracy, known, progress));
        std::vector<Reference> result(points.size());
        for (std::size_t k = 0; k < points.size(); ++k) {
            Reference& reference = result[k];
            reference.point = points[k].displayed;
            reference.shaded = points[k].displayed_radiance();
            reference.direct_product = direct[k][0].dot(direct[k][1]);
            reference.direct = (direct[k][0] + direct[k][1]) * 0.5;
        }
        if (!shading.indirect) return result;
        HF_TRY(const Pairs indirect,
               indirect_errors(points, accuracy, traced_weights, known_paths, progress));
        for (std::size_t k = 0; k < indirect.size(); ++k) {
            Reference& reference = result[k];
            reference.has_indirect = true;
            reference.indirect_product = indirect[k][0].dot(indirect[k][1]);
            reference.mixed_product = direct[k][0].dot(indirect[k][1]) + direct[k][1].dot(indirect[k][0]);
            reference.indirect = (indirect[k][0] + indirect[k][1]) * 0.5;
        }
        return result;
    }

    /// Compares the indirect light of the first points with paths, as many as their noise requires.
    ///
    /// known  references of the first points; those of the others are added, and those with too few paths are
    ///        replaced.
    Result<Pairs> indirect_errors(std::span<const ShadedPoint> points, double accuracy,
                                  std::span<const double> weights, std::vector<Truth::PathPair>& known,
                                  const Progress& progress) const {
        const PathTracer paths(*truth->rays, *shading.indirect->surface);
        const std::size_t traced = weights.size(), first = known.size();
        const auto reference = [&](std::size_t k, std::uint32_t samples, std::uint32_t seed) {
            const ShadedPoint& point = points[k];
            const ShadingPoint seen =
                shading_point(shading.scene, shading.scene.instances[point.at.instance], point.at.point);
            return point.displayed.displayed(paths.indirect_radiance(seen.from, seen.brdf, samples, seed));
        };
        std::vector<std::size_t> missing;
        for (std::size_t k = first; k < traced; ++k) missing.push_back(k);
        HF_TRY(const auto pilot,
               estimates<pilot_estimates>(
                   missing,
                   [&](std::size_t k, std::uint32_t seed) { return reference(k, pilot_samples, ~seed); },
                   progress));
        known.resize(std::max(first, traced));
        for (std::size_t n = 0; n < missing.size(); ++n)
            known[missing[n]].variance = pilot_samples * variance_of(pilot[n]);
        std::vector<double> variances(traced);
        for (std::size_t k = 0; k < traced; ++k) variances[k] = known[k].variance;
        const double wanted = std::pow(path_noise_share * accuracy, 2) * mean_square;
        for (double goal = wanted;; goal /= 4) {
            const PathCounts samples = path_counts(variances, weights, goal);
            missing.clear();
            for (std::size_t k = 0; k < traced; ++k)
                if (known[k].samples < samples.by_point[k]) missing.push_back(k);
            HF_TRY(const auto found, estimates<2>(
                                         missing,
                                         [&](std::size_t k, std::uint32_t seed) {
                                             return reference(k, samples.by_point[k], seed);
                                         },
                                         progress));
            for (std::size_t n = 0; n < missing.size(); ++n) {
                Truth::PathPair& pair = known[missing[n]];
                pair.samples = samples.by_point[missing[n]];
                pair.displayed = found[n];
            }
            Pairs errors(traced);
            for (std::size_t k = 0; k < traced; ++k)
                for (std::size_t r = 0; r < 2; ++r)
                    errors[k][r] = points[k].displayed.displayed(points[k].indirect) - known[k].displayed[r];
            if (samples.are_limited || product_deviation(errors, weights) <= 2 * wanted) return errors;
        }
    }

    /// Returns independent estimates for points.
    ///
    /// estimate  (std::size_t point, std::uint32_t seed) -> Vec3d. Called from many threads.
    template <std::size_t count, class Estimate>
    static Result<std::vector<std::array<Vec3d, count>>> estimates(std::span<const std::size_t> points,
                                                                   const Estimate& estimate,
                                                                   const Progress& progress) {
        std::vector<std::array<Vec3d, count>> result(points.size());
        HF_TRY_DONE(parallel_loop(
            {points.size()},
            [&]() -> LoopBody {
                return [&](std::size_t n) {
                    for (std::uint32_t r = 0; r < count; ++r)
                        result[n][r] = estimate(points[n], mixed_seed(std::uint32_t(points[n]), r));
                };
            },
            "reference points", progress));
        return result;
    }

    /// Chooses points: strata by octaves of Displayed::difference, with Neyman's allocation.
    Result<StratifiedPoints> stratified(const DisplayedRadiance& bake, std::uint32_t seed, std::size_t count,
                                        const Progress& progress) {
        HF_TRY_DONE(prepare(progress));
        // Octaves of the expected error, from a 4096th of the RMS radiance on.
        constexpr std::size_t octaves = 16;
        std::vector<std::uint8_t> octave(population.size());
        const double unit = 3 * root(mean_square / 3) / 4096;
        tbb::parallel_for(std::size_t(0), population.size(), [&](std::size_t k) {
            const DisplayedPoint& displayed_point = population[k];
            const double expected =
                double(bake(displayed_point.at).difference) *
                (channel_sum(displayed_point.diffuse) + channel_sum(displayed_point.specular)) / 6;
            const double above = unit > 0 ? std::log2(std::max(1e-30, expected / unit)) : 0;
            octave[k] = std::uint8_t(std::clamp(above + 1, 0.0, double(octaves - 1)));
        });
        std::array<std::vector<std::size_t>, octaves> members;
        for (std::size_t k = 0; k < population.size(); ++k) members[octave[k]].push_back(k);
        // Neyman: in proportion to the deviation of the squared error, that is to the squared expectation;
        // half of the points in proportion to size, for errors that nothing foretells.
        std::array<double, octaves> wanted{};
        double all = 0;
        for (std::size_t s = 0; s < octaves; ++s) {
            wanted[s] = double(members[s].size()) * std::exp2(2 * double(s));
            all += wanted[s];
        }
        std::mt19937 random(mixed_seed(3, seed));
        StratifiedPoints result;
        std::vector<std::size_t> numbers;
        for (std::size_t s = 0; s < octaves; ++s) {
            result.weights.push_back(double(members[s].size()) / double(population.size()));
            double& drawn = result.shares.emplace_back(0);
            if (members[s].empty()) continue;
            const double share =
                0.5 * wanted[s] / all + 0.5 * double(members[s].size()) / double(population.size());
            const std::size_t wanted_points =
                std::min(members[s].size(), std::max<std::size_t>(16, std::size_t(share * double(count))));
            drawn = double(wanted_points) / double(members[s].size());
            for (std::size_t k = 0; k < wanted_points; ++k) {
                std::swap(members[s][k], members[s][k + number_below(random, members[s].size() - k)]);
                if (!point(members[s][k])) continue;
                numbers.push_back(members[s][k]);
                result.stratum.push_back(s);
            }
        }
        HF_TRY(result.points, shaded(numbers, progress));
        return result;
    }

    Interpolation interpolation(const DisplayedRadiance& bake, const StratifiedPoints& points,
                                double wanted = 0) const {
        std::vector<WeightedValues> strata;
        for (std::size_t s = 0; s < points.weights.size(); ++s)
            strata.push_back({points.weights[s], {}, points.shares[s]});
        Interpolation result;
        result.points = points.points.size();
        for (std::size_t k = 0; k < points.points.size(); ++k) {
            const ShadedPoint& shown = points.points[k];
            const double square = square_of(shown.displayed.displayed(bake(shown.displayed.at).radiance) -
                                            shown.displayed_radiance());
            strata[points.stratum[k]].values.push_back(square);
            const double error = root(square * scale());
            if (error > result.worst.error) result.worst = {shown.displayed, error, true};
        }
        result.square = estimate(strata, scale());
        std::vector<std::size_t> numbers(strata.size());
        for (std::size_t k = 0; k < points.points.size() && wanted > 0; ++k) {
            const WeightedValues& stratum = strata[points.stratum[k]];
            const double square = stratum.values[numbers[points.stratum[k]]++];
            if (square * scale() * stratum.weight / double(stratum.values.size()) > wanted * wanted / 64)
                result.largest.push_back({points.points[k].displayed.at, points.points[k].radiance()});
        }
        return result;
    }

    double scale() const { return mean_square > 0 ? 1 / mean_square : 0; }

    /// Not a reference: frames of sessions replace their shading.
    const PointShading shading;
    const std::shared_ptr<Truth> truth;
    const std::vector<DisplayedPoint>& population;    ///< Of the truth.
    StratifiedPoints steering{{}, {}, {1.0}, {0.0}};  ///< Drawn with repetition.
    double mean_square = 0;                           ///< Of the displayed radiance.
};

BakeErrorMeter::BakeErrorMeter(const PointShading& shading, std::vector<DisplayedPoint> population)
    : state_(
          std::make_unique<State>(shading, std::make_shared<Truth>(shading.scene, std::move(population)))) {}
BakeErrorMeter::BakeErrorMeter(const PointShading& shading, const BakeErrorMeter& other)
    : state_(std::make_unique<State>(shading, other.state_->truth)) {}
BakeErrorMeter::BakeErrorMeter(BakeErrorMeter&&) noexcept = default;
BakeErrorMeter& BakeErrorMeter::operator=(BakeErrorMeter&&) noexcept = default;
BakeErrorMeter::~BakeErrorMeter() = default;

Result<BakeErrorMeter::Shading> BakeErrorMeter::shading_error(double accuracy, const Progress& progress,
                                                              std::size_t count) {
    HF_TRY_DONE(state_->prepare_scale(progress));
    HF_TRY(const std::vector<ShadedPoint> points, state_->shaded(state_->chosen(count, 2), progress));
    Shading result;
    const std::size_t traced = std::min(path_points, points.size());
    const std::vector<double> weights(traced, 1 / double(std::max<std::size_t>(1, traced)));
    HF_TRY(result.references, state_->references(points, accuracy, state_->truth->of_shading_points,
                                                 state_->truth->paths_of_shading_points, weights, progress));
    WeightedValues direct{1, {}}, indirect{1, {}}, both{1, {}};
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

Result<BakeErrorMeter::Interpolation> BakeErrorMeter::steering_error(const DisplayedRadiance& bake,
                                                                     const Progress& progress,
                                                                     double wanted) {
    HF_TRY_DONE(state_->prepare(progress));
    return state_->interpolation(bake, state_->steering, wanted);
}

Result<BakeErrorMeter::Interpolation> BakeErrorMeter::interpolation_error(const DisplayedRadiance& bake,
                                                                          std::uint32_t seed,
                                                                          std::size_t count,
                                                                          const Progress& progress,
                                                                          double wanted) {
    HF_TRY(const StratifiedPoints points, state_->stratified(bake, seed, count, progress));
    return state_->interpolation(bake, points, wanted);
}

Result<BakeErrorMeter::Interpolation> BakeErrorMeter::reported_error(const DisplayedRadiance& bake,
                                                                     std::uint32_t seed, double accuracy,
                                                                     const Progress& progress) {
    constexpr std::size_t count = 8192, referenced = 1536, traced = 1024;
    HF_TRY(const StratifiedPoints points, state_->stratified(bake, seed, count, progress));
    Interpolation result = state_->interpolation(bake, points);
    // The first points of each stratum: those that are traced come before the others.
    std::vector<std::size_t> seen(points.weights.size()), chosen, of_all(points.weights.size());
    for (const std::size_t s : points.stratum) ++of_all[s];
    const auto share_of = [&](std::size_t s, std::size_t total) {
        return std::max<std::size_t>(4, of_all[s] * total / count);
    };
    std::vector<std::size_t> untraced;
    for (std::size_t k = 0; k < points.points.size(); ++k) {
        const std::size_t s = points.stratum[k], before = seen[s]++;
        if (before < share_of(s, traced))
            chosen.push_back(k);
        else if (before < share_of(s, referenced))
            untraced.push_back(k);
    }
    const std::size_t first_untraced = chosen.size();
    chosen.insert(chosen.end(), untraced.begin(), untraced.end());
    std::vector<ShadedPoint> selected;
    for (const std::size_t k : chosen) selected.push_back(points.points[k]);
    std::vector<std::size_t> traced_of(points.weights.size());
    for (std::size_t n = 0; n < first_untraced; ++n) ++traced_of[points.stratum[chosen[n]]];
    std::vector<double> weights;
    for (std::size_t n = 0; n < first_untraced; ++n) {
        const std::size_t s = points.stratum[chosen[n]];
        weights.push_back(points.weights[s] / double(traced_of[s]));
    }
    std::vector<Truth::DirectPair> direct;
    std::vector<Truth::PathPair> paths;
    // The noise must be small compared with the error that is reported.
    const double expected = std::clamp(root(result.square.square), std::min(0.5 * accuracy, 0.005), accuracy);
    HF_TRY(const std::vector<Reference> references,
           state_->references(selected, expected, direct, paths, weights, progress));
    for (const double weight : points.weights) result.strata.push_back({weight, {}});
    for (std::size_t n = 0; n < chosen.size(); ++n)
        result.strata[points.stratum[chosen[n]]].references.push_back(references[n]);
    return result;
}

BakeError BakeErrorMeter::error(const DisplayedRadiance& bake, const Interpolation& between,
                                const Shading& shading) const {
    BakeError error;
    error.between = root(between.square.square);
    error.points = between.points;
    error.worst = between.worst;
    std::vector<Stratum> strata = between.strata;
    if (strata.empty()) strata.push_back({1, shading.references});
    // `alone` is that of the shading itself. `others` adds its products with interpolation.
    std::vector<WeightedValues> direct, indirect, alone, others;
    for (const Stratum& stratum : strata) {
        const WeightedValues none{stratum.weight, {}};
        WeightedValues of_direct = none, of_indirect = none, of_both = none, with_direct = none,
                       with_indirect = none;
        for (const Reference& reference : stratum.references) {
            const Vec3d off = reference.point.displayed(bake(reference.point.at).radiance) - reference.shaded;
            of_direct.values.push_back(reference.direct_product);
            with_direct.values.push_back(reference.direct_product + 2 * off.dot(reference.direct));
            if (reference.has_indirect) {
                of_indirect.values.push_back(reference.indirect_product);
                of_both.values.push_back(reference.indirect_product + reference.mixed_product);
                with_indirect.values.push_back(of_both.values.back() + 2 * off.dot(reference.indirect));
            }
            const double here =
                root(square_of(off + reference.direct + reference.indirect) * state_->scale());
            if (here > error.worst.error) error.worst = {reference.point, here, false};
        }
        alone.push_back(of_direct);
        alone.push_back(std::move(of_both));
        direct.push_back(std::move(of_direct));
        indirect.push_back(std::move(of_indirect));
        others.push_back(std::move(with_direct));
        others.push_back(std::move(with_indirect));
        error.references += stratum.references.size();
    }
    error.at_vertices = root(weighted_mean(direct) * state_->scale());
    error.indirect = root(weighted_mean(indirect) * state_->scale());
    error.shading = root(weighted_mean(alone) * state_->scale());
    const SquareEstimate beside = estimate(others, state_->scale());
    // Interpolation can remove the noise of the shading, but no more than that.
    const double least = -error.shading * error.shading;
    const auto sum = [&](double square, double other) { return root(square + std::max(other, least)); };
    error.total = sum(between.square.square, beside.square);
    std::vector<double> totals;
    for (std::size_t k = 0; k < between.square.resampled.size(); ++k)
        totals.push_back(sum(between.square.resampled[k], beside.resampled[k]));
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
