#include "shading/bake/error_target.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "shading/bake/bounced_radiance.h"
#include "shading/visibility/placed_solids.h"

namespace haarfield {
namespace {

/// The share of the shading's error that interpolation may have if the shading alone exceeds the target.
constexpr double least_share = 0.5;
/// The share of the target at which the search ends, since other points measure the reported error.
constexpr double margin = 0.93;
/// Indirect light gets more directions while its error exceeds this share of the target.
constexpr double largest_indirect_share = 0.4;
constexpr int most_directions = 2048;
/// Neither more directions nor more vertices are tried if the bounces that are left out exceed this share of
/// the target.
constexpr double largest_left_out_share = 0.5;
/// A search may stop early if the error of indirect light exceeds this share of the target.
constexpr double stopping_share = 0.8;
/// The share of the target that the noise of gathered irradiance may have.
constexpr double gathering_share = 0.25;
constexpr int fewest_rays = 32, most_rays = 1024;
constexpr std::size_t gathering_points = 128;
/// Directions of sources or wavelets are more, or faces larger, while the error of direct light exceeds this
/// share of the target.
constexpr double largest_direct_share = 0.5;
constexpr std::size_t direct_points = 192;
/// Faces are larger than usual while the error exceeds this share.
constexpr double unreachable_share = 0.8;
/// A choice helps if it reduces the error of direct light to this share.
constexpr double helpful_share = 0.8;
constexpr int most_direction_factor = 16;
/// Factors by which a step may multiply the vertices: few near the target, where each step is measured.
constexpr double least_growth = 1.06, largest_growth = 4;
/// Factors by which the vertices grow between two measurements.
constexpr double least_interval = 1.04, largest_interval = 1.25;
/// Cuts are tried while the error is below this multiple of the target.
constexpr double largest_cut_error = 10;
/// They are tried again when the vertices have grown by this factor, or by the second one if the last cuts
/// did not help.
constexpr double cut_interval = 1.5, long_cut_interval = 4;
/// Cuts help if they reduce the mean square error to this share.
constexpr double helpful_cut = 0.6;
/// Cuts that helped are tried again at once if the same factor would reduce the error below this multiple of
/// the target: cuts of finer meshes help more.
constexpr double likely_cut_error = 2;
/// The largest share of the target that the shading is expected to add while its own error is smaller: its
/// product with interpolation becomes smaller with more vertices.
constexpr double most_beside = 0.85;
/// The most reports: while one exceeds the target, the refinement continues.
constexpr int most_reports = 3;
/// Edges with errors below this share of the target are not split. If this ends the refinement too early,
/// the share is halved down to the second one.
constexpr double tolerated_share = 0.25, least_tolerated_share = 0.25 / 16;

/// Returns an end of the interval that contains 90 % of the estimates of a mean square.
///
/// twentieth  1: the lower end; 19: the upper end.
SquareEstimate interval_end(SquareEstimate estimate, std::size_t twentieth) {
    std::vector<double> squares = estimate.resampled;
    std::ranges::sort(squares);
    estimate.square = squares.empty() ? 0 : std::max(0.0, squares[squares.size() * twentieth / 20]);
    return estimate;
}

double root(double square) {
    return std::sqrt(std::max(0.0, square));
}

template <class Radiance>
Outgoing interpolated(const Radiance& radiance, const std::array<std::uint32_t, 3>& corners,
                      const std::array<float, 3>& weights) {
    Outgoing sum;
    for (std::size_t k = 0; k < 3; ++k) sum += radiance[corners[k]] * weights[k];
    return sum;
}

/// Returns the values that a refinement displays.
///
/// fitted, cut  null: sampled radiance. At most one is given.
BakeErrorMeter::DisplayedRadiance displayed_radiance(const MeshRefiner& refiner, const SceneRadiance* fitted,
                                                     const DiscontinuityMeshes* cut) {
    return [&refiner, fitted, cut](const MeshPoint& at) -> BakeErrorMeter::Displayed {
        const MeshRefiner::Located found = refiner.located(at);
        if (cut) {
            const DiscontinuityMeshes::Located part =
                cut->located(at.instance, found.triangle, found.weights);
            return {interpolated(cut->meshes()[at.instance].radiance, part.corners, part.weights),
                    found.difference};
        }
        return {fitted ? interpolated((*fitted)[at.instance], found.corners, found.weights)
                       : interpolated(refiner.radiance(at.instance), found.corners, found.weights),
                found.difference};
    };
}

/// Refines meshes until interpolation reaches a target.
class Search {
public:
    Search(const PointShading& shading, const ErrorTarget& target, BakeErrorMeter& meter,
           const BakeErrorMeter::Shading& measured)
        : shading_(shading),
          target_(target),
          meter_(meter),
          measured_(measured),
          alone_(root(measured.all.square)),
          beside_(alone_) {}

    Result<Done> operator()(std::vector<RadiantMesh> start, VertexMask visible, TargetBake& bake,
                            const Progress& progress) {
        MeshRefiner refiner(
            shading_,
            {static_cast<float>(tolerated_ * target_.error), target_.vertex_budget, target_.by_view, true},
            std::move(start), std::move(visible));
        BakeErrorMeter::Interpolation between;
        for (int reports = 1;; ++reports) {
            HF_TRY_DONE(refine(refiner, progress));
            HF_TRY(between, meter_.reported_error(shown(refiner), ++seed_, target_.error, progress));
            bake.error = meter_.error(shown(refiner), between, measured_);
            alone_ = bake.error.shading;
            const double interpolation = root(between.square.square);
            const double beside = root(bake.error.total * bake.error.total - interpolation * interpolation);
            beside_ = std::min(beside, std::max(alone_, most_beside * target_.error));
            if (is_exhausted_ || reports == most_reports || is_enough(between.square, 1)) break;
            refiner.add_known(between.largest);
            set_growth(between.square);
        }
        bake.fitted = fitted_.has_value();
        bake.end = end(bake.error, refiner);
        Refinement refined = std::move(refiner).finished();
        bake.rounds = refined.rounds;
        bake.shaded_points = refined.shaded_points;
        if (cut_) {
            bake.cut_edges = cut_->cut_edges();
            bake.meshes = std::move(*cut_).take_meshes();
            return Done{};
        }
        bake.meshes = std::move(refined.meshes);
        if (fitted_)
            for (std::size_t i = 0; i < bake.meshes.size(); ++i)
                bake.meshes[i].radiance = std::move((*fitted_)[i]);
        return Done{};
    }

private:
    /// Refines until the target seems to be reached, or until this is no longer possible.
    Result<Done> refine(MeshRefiner& refiner, const Progress& progress) {
        for (bool can_refine = true;;) {
            if (refiner.vertices() >= next_measured_ || !can_refine) {
                is_exhausted_ = !can_refine && (is_budget_used_up_ || refiner.is_budget_used_up() ||
                                                tolerated_ <= least_tolerated_share);
                HF_TRY(const bool done, is_done(refiner, progress));
                next_measured_ = static_cast<std::size_t>(
                    double(refiner.vertices()) *
                    std::clamp(std::sqrt(growth_), least_interval, largest_interval));
                if (done || is_exhausted_) return Done{};
                if (!can_refine) {
                    tolerated_ /= 2;
                    refiner.set_tolerance(static_cast<float>(tolerated_ * target_.error));
                }
            }
            const auto most = static_cast<std::size_t>(growth_ * double(refiner.vertices()));
            if (most_uncut() <= refiner.vertices()) {
                can_refine = false;
                is_budget_used_up_ = true;
                continue;
            }
            HF_TRY(can_refine, refiner.step(progress, std::min(most, most_uncut())));
        }
    }

    BakeErrorMeter::DisplayedRadiance shown(const MeshRefiner& refiner) const {
        return displayed_radiance(refiner, fitted_ ? &*fitted_ : nullptr, cut_ ? &*cut_ : nullptr);
    }

    /// Returns the largest number of vertices that leaves enough of the budget for cuts.
    std::size_t most_uncut() const {
        return static_cast<std::size_t>(double(target_.vertex_budget) / (1 + cut_share_));
    }

    /// Measures the current meshes, and chooses between sampled and fitted colours and cut meshes.
    Result<bool> is_done(MeshRefiner& refiner, const Progress& progress) {
        fitted_.reset();
        cut_.reset();
        HF_TRY(const BakeErrorMeter::Interpolation steering,
               meter_.steering_error(shown(refiner), progress, target_.error));
        refiner.add_known(steering.largest);
        SquareEstimate error = steering.square;
        growth_ = largest_growth;
        // Fitted colours reduce the error to less than a half.
        if (root(error.square) <= 3 * target_.error) {
            fitted_ = refiner.fitted();
            HF_TRY(const BakeErrorMeter::Interpolation fit, meter_.steering_error(shown(refiner), progress));
            const SquareEstimate& by_fit = fit.square;
            if (by_fit.square < error.square)
                error = by_fit;
            else
                fitted_.reset();
        }
        if (!is_enough(error, 1) && may_cut(refiner, error)) {
            const auto by_steering = [&] { return meter_.steering_error(shown(refiner), progress); };
            HF_TRY_DONE(try_cut(refiner, error, by_steering, progress));
        }
        if (root(error.square) > 3 * target_.error) return false;
        set_growth(error);
        if (!is_enough(error, 1)) return false;
        // Other points than the steering ones decide. A close decision takes more of them, which cost less
        // than the vertices that a wide interval would demand.
        ++seed_;
        std::size_t points = 2048;
        const auto by_others = [&] {
            return meter_.interpolation_error(shown(refiner), seed_, points, progress, target_.error);
        };
        for (;; points = 8192) {
            HF_TRY(const BakeErrorMeter::Interpolation between, by_others());
            refiner.add_known(between.largest);
            error = between.square;
            set_growth(error);
            if (is_enough(interval_end(error, 19), margin)) return true;
            if (points == 8192 || !is_enough(interval_end(error, 1), 1)) break;
        }
        if (cut_ || !may_cut(refiner, error)) return false;
        HF_TRY_DONE(try_cut(refiner, error, by_others, progress));
        set_growth(error);
        return is_enough(interval_end(error, 19), margin);
    }

    bool may_cut(const MeshRefiner& refiner, const SquareEstimate& error) const {
        return root(error.square) <= largest_cut_error * target_.error &&
               ((is_exhausted_ && refiner.vertices() > last_cut_) || refiner.vertices() >= next_cut_ ||
                (cuts_help_ && root(error.square * cut_factor_) <= likely_cut_error * target_.error));
    }

    /// Cuts the meshes along hard shadow edges if that reduces the error.
    ///
    /// error     of the meshes without cuts; afterwards of those that are chosen.
    /// measured  () -> Result<Interpolation>. The error of what is shown, by the same points as `error`.
    template <class Measure>
    Result<Done> try_cut(const MeshRefiner& refiner, SquareEstimate& error, const Measure& measured,
                         const Progress& progress) {
        const double vertices = double(refiner.vertices());
        double interval = cut_interval;
        cut_share_ = 0;
        HF_TRY(cut_, refiner.cut(target_.vertex_budget, cuts_help_ ? CutSearch::all : CutSearch::sampled,
                                 progress));
        if (cut_->cut_edges() == 0) {
            cut_.reset();
            cuts_help_ = false;
        } else {
            std::optional<SceneRadiance> fitted = std::exchange(fitted_, {});
            HF_TRY(const BakeErrorMeter::Interpolation cut, measured());
            const SquareEstimate& by_cut = cut.square;
            cut_factor_ = by_cut.square / error.square;
            cuts_help_ = cut_factor_ < helpful_cut;
            if (!cuts_help_) interval = long_cut_interval;
            // Cuts that help little are no reason to stop refining earlier.
            if (by_cut.square < error.square / 2) cut_share_ = double(cut_->added_vertices()) / vertices;
            if (by_cut.square < error.square) {
                error = by_cut;
            } else {
                cut_.reset();
                fitted_ = std::move(fitted);
            }
        }
        last_cut_ = refiner.vertices();
        next_cut_ = static_cast<std::size_t>(interval * vertices);
        return Done{};
    }

    /// Limits the next step. Errors of interpolation are about inversely proportional to the number of
    /// vertices.
    void set_growth(const SquareEstimate& between) {
        const double allowed = std::max(root(target_.error * target_.error - beside_ * beside_),
                                        least_share * std::max(target_.error, alone_));
        growth_ = std::clamp(root(between.square) / allowed, least_growth, largest_growth);
    }

    /// True if the whole error reaches the target with this error of interpolation, or if the shading misses
    /// it and interpolation adds little.
    ///
    /// share  of the target.
    bool is_enough(const SquareEstimate& between, double share) const {
        const double interpolation = root(between.square), wanted = share * target_.error;
        return std::hypot(beside_, interpolation) <= wanted ||
               (alone_ > wanted && interpolation <= least_share * alone_);
    }

    SearchEnd end(const BakeError& error, const MeshRefiner& refiner) const {
        if (error.total <= target_.error) return SearchEnd::reached;
        const double largest = std::max({error.between, error.at_vertices, error.indirect});
        if (largest == error.between) {
            if (is_budget_used_up_ || refiner.is_budget_used_up()) return SearchEnd::vertex_budget;
            return is_exhausted_ ? SearchEnd::short_edges : SearchEnd::little_gain;
        }
        return largest == error.at_vertices ? SearchEnd::direct_light : SearchEnd::indirect_light;
    }

    const PointShading& shading_;
    const ErrorTarget& target_;
    BakeErrorMeter& meter_;
    const BakeErrorMeter::Shading& measured_;
    std::uint32_t seed_ = 0;
    double alone_;  ///< The error of the shading: at the points of the last report, or of measured_.
    /// The error that the shading adds to that of interpolation. It is less than alone_ where interpolation
    /// removes noise, and more where both errors are alike.
    double beside_;
    double tolerated_ = tolerated_share;  ///< The share of the target below which edges are not split.
    std::size_t next_measured_ = 0;       ///< Vertices at which errors are measured again.
    double growth_ = largest_growth;      ///< Largest factor by which the next step multiplies the vertices.
    std::optional<SceneRadiance> fitted_;
    std::optional<DiscontinuityMeshes> cut_;
    double cut_factor_ = 1;     ///< By which the last cuts multiplied the mean square error.
    bool cuts_help_ = false;    ///< The last cuts reduced the error much.
    std::size_t last_cut_ = 0;  ///< Vertices at which cuts were tried.
    std::size_t next_cut_ = 0;  ///< Vertices at which cuts are tried again.
    double cut_share_ = 0;      ///< Vertices that cuts add, relative to the others.
    bool is_budget_used_up_ = false;
    bool is_exhausted_ = false;  ///< No edge can be split any more.
};

/// Returns the fine meshes with their radiance, which is extrapolated to vertices inside other instances.
///
/// indirect  with gathered irradiance; null: no bounces.
std::vector<RadiantMesh> radiant_fine_meshes(const ShadedScene& scene, SceneRadiance radiance,
                                             const IndirectLight* indirect) {
    const PlacedSolids solids(scene);
    std::vector<RadiantMesh> meshes;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        RadiantMesh& mesh = meshes.emplace_back(
            RadiantMesh{*entity.mesh, std::move(radiance[i]), entity.occlusion->samples()});
        mesh.samples.buried = solids.buried_vertices(scene, i, mesh.mesh, entity.occlusion->samples());
        BuriedFill(mesh.mesh, mesh.samples.buried)(mesh.radiance);
        for (std::size_t v = 0; indirect && v < mesh.radiance.size(); ++v)
            mesh.irradiance.push_back({indirect->irradiance[i][v], indirect->nearness[i][v]});
    }
    return meshes;
}

/// Returns for each vertex of the fine meshes whether one of its triangles contains a displayed point.
VertexMask displayed_vertices(const ShadedScene& scene, std::span<const DisplayedPoint> population) {
    VertexMask result;
    for (const ShadedInstance& instance : scene.instances)
        result.emplace_back(scene.entities[instance.entity].mesh->positions.size());
    for (const DisplayedPoint& point : population) {
        const Mesh& mesh = *scene.entities[scene.instances[point.at.instance].entity].mesh;
        for (const std::uint32_t v : mesh.triangles[point.at.triangle]) result[point.at.instance][v] = true;
    }
    return result;
}

/// Geometry and light that a search prepared; none: those that it was given.
struct DirectChoice {
    std::optional<ShadingGeometry> geometry;
    std::optional<SceneLight> light;

    PointShading shading(const PointShading& direct, const RenderSettings& settings,
                         const IndirectLight* indirect = nullptr) const {
        return {direct.scene,
                geometry ? *geometry : direct.geometry,
                light ? *light : direct.light,
                settings,
                nullptr,
                indirect};
    }
};

/// Chooses the direct light: few directions of suns and windows, small faces and few wavelets. Starts with
/// those of the settings, and sets what it chose in them.
///
/// meter  of the direct light.
Result<DirectChoice> chosen_direct_light(const PointShading& direct, const ErrorTarget& target,
                                         const BakeErrorMeter& meter, RenderSettings& settings,
                                         const Progress& progress) {
    const auto error_of = [&](const DirectChoice& choice) -> Result<SquareEstimate> {
        HF_TRY(BakeErrorMeter::Shading found, BakeErrorMeter(choice.shading(direct, settings), meter)
                                                  .shading_error(target.error, progress, direct_points));
        return std::move(found.direct);
    };
    // Few points, and the noise of their references, must not hide a large error.
    const auto is_accurate = [&](const SquareEstimate& error) {
        return root(interval_end(error, 19).square) <= largest_direct_share * target.error;
    };
    DirectChoice chosen;
    HF_TRY(SquareEstimate error, error_of(chosen));
    // Returns whether light by another value of a setting helps. Otherwise, the value is that of before.
    const auto helps = [&](int& setting, int value) -> Result<bool> {
        const int before = std::exchange(setting, value);
        std::optional<SceneLight> light =
            std::exchange(chosen.light, scene_light(direct.scene, settings, progress.stop));
        HF_TRY(SquareEstimate found, error_of(chosen));
        if (root(found.square) <= helpful_share * root(error.square)) {
            error = std::move(found);
            return true;
        }
        setting = before;
        chosen.light = std::move(light);
        return false;
    };
    const auto by_faces = [&]() -> Result<DirectChoice> {
        DirectChoice choice;
        HF_TRY(choice.geometry, shading_geometry(direct.scene, settings, progress));
        choice.light = scene_light(direct.scene, settings, progress.stop);
        return choice;
    };
    bool may_add_directions = !direct.light.sources.empty(), may_add_wavelets = true;
    while (!is_accurate(error)) {
        int &factor = settings.sources.direction_factor, &wavelets = settings.light_coefficients;
        if (may_add_directions && factor < most_direction_factor) {
            HF_TRY(may_add_directions, helps(factor, most_direction_factor));
        } else if (settings.face_size < target.usual_face_size) {
            settings.face_size *= 2;
            HF_TRY(chosen, by_faces());
            HF_TRY(SquareEstimate found, error_of(chosen));
            // Directions that did not help before may help with faces that do.
            may_add_directions =
                !direct.light.sources.empty() && root(found.square) <= helpful_share * root(error.square);
            error = std::move(found);
        } else if (may_add_wavelets && wavelets > 0 && wavelets < settings.face_size * settings.face_size) {
            HF_TRY(may_add_wavelets, helps(wavelets, 0));
        } else if (settings.face_size < target.most_face_size &&
                   root(error.square) > unreachable_share * target.error) {
            settings.face_size *= 2;
            HF_TRY(DirectChoice larger, by_faces());
            HF_TRY(SquareEstimate found, error_of(larger));
            if (root(found.square) > helpful_share * root(error.square)) {
                settings.face_size /= 2;
                break;
            }
            chosen = std::move(larger);
            error = std::move(found);
            may_add_wavelets = true;
        } else {
            break;
        }
    }
    return chosen;
}

/// Chooses the fewest rays with which gathered irradiance is accurate enough, in comparison with many rays at
/// some of the displayed points.
///
/// lit       with its indirect light.
/// radiance  of the direct light, by instance and vertex.
int chosen_gathering_rays(const PointShading& lit, const ErrorTarget& target,
                          std::span<const DisplayedPoint> population, const SceneRadiance& radiance) {
    struct GatheredPoint {
        DisplayedPoint displayed;
        SurfacePoint surface;
        Rgb reflectance;  ///< Albedo / pi. [1/sr]
        Rgb irradiance;   ///< By many rays. [W/m^2]
    };
    std::vector<GatheredPoint> points;
    for (std::size_t k = 0; k < gathering_points && !population.empty(); ++k) {
        const DisplayedPoint& displayed = population[k * population.size() / gathering_points];
        const ShadedInstance& instance = lit.scene.instances[displayed.at.instance];
        if (const auto at = surface_point(lit.scene.entities[instance.entity], displayed.at))
            points.push_back({displayed, *at, shading_point(lit.scene, instance, *at).brdf.diffuse, {}});
    }
    tbb::parallel_for(std::size_t(0), points.size(), [&](std::size_t k) {
        GatheredPoint& point = points[k];
        point.irradiance =
            lit.indirect->gathered_at(lit.scene, point.displayed.at.instance, point.surface, 4 * most_rays)
                .irradiance;
    });
    double all = 0;
    for (const GatheredPoint& point : points) {
        const MeshPoint& at = point.displayed.at;
        const auto& corners =
            lit.scene.entities[lit.scene.instances[at.instance].entity].mesh->triangles[at.triangle];
        Outgoing shown = interpolated(radiance[at.instance], corners, at.weights());
        shown.diffuse += point.reflectance * point.irradiance;
        all += point.displayed.displayed(shown).length2();
    }
    const double allowed = std::pow(gathering_share * target.error, 2) * all;
    int rays = fewest_rays;
    for (; rays < most_rays; rays *= 2) {
        std::vector<double> errors(points.size());
        tbb::parallel_for(std::size_t(0), points.size(), [&](std::size_t k) {
            const GatheredPoint& point = points[k];
            const Rgb found =
                lit.indirect->gathered_at(lit.scene, point.displayed.at.instance, point.surface, rays)
                    .irradiance;
            errors[k] = point.displayed.displayed({point.reflectance * (found - point.irradiance)}).length2();
        });
        if (std::accumulate(errors.begin(), errors.end(), 0.0) <= allowed) break;
    }
    return rays;
}

/// Indirect light, and the error of the shading with it.
struct IndirectChoice {
    IndirectLight light;
    int directions = 0;  ///< BounceSettings::directions.
    BakeErrorMeter::Shading measured;

    double error() const { return root(measured.indirect.square); }
    bool leaves_out(double wanted) const { return light.left_out > largest_left_out_share * wanted; }
};

/// Chooses the indirect light: the first one that is accurate enough, or else the most accurate one. Tries
/// focused_indirect_light second, and then more directions.
///
/// direct    its settings have the fewest directions.
/// radiance  of the direct light, by instance and vertex.
/// meter     of the same scene; its references are shared.
Result<IndirectChoice> chosen_indirect_light(const PointShading& direct, const ErrorTarget& target,
                                             std::span<const DisplayedPoint> population,
                                             const SceneRadiance& radiance, const BakeErrorMeter& meter,
                                             const Progress& progress) {
    RenderSettings settings = direct.settings;
    std::optional<BounceRays> rays;
    const auto tried = [&](bool is_focused) -> Result<IndirectChoice> {
        PointShading lit{direct.scene, direct.geometry, direct.light, settings};
        if (!rays) {
            HF_TRY(rays, bounce_rays(direct.scene, direct.geometry, settings, progress));
        }
        HF_TRY(IndirectLight light, is_focused ? focused_indirect_light(lit, radiance, *rays, progress)
                                               : scene_indirect_light(lit, radiance, *rays, progress));
        lit.indirect = &light;
        light.gathering_rays = chosen_gathering_rays(lit, target, population, radiance);
        HF_TRY(BakeErrorMeter::Shading measured,
               BakeErrorMeter(lit, meter).shading_error(target.error, progress));
        return IndirectChoice{std::move(light), settings.bounces.directions, std::move(measured)};
    };
    const double wanted = largest_indirect_share * target.error;
    HF_TRY(IndirectChoice best, tried(false));
    bool is_focused = false;
    const auto try_another = [&](bool with_focus) -> Result<Done> {
        HF_TRY(IndirectChoice other, tried(with_focus));
        is_focused = with_focus && other.error() < best.error();
        if (other.error() < best.error()) best = std::move(other);
        return Done{};
    };
    if (best.error() > wanted) HF_TRY_DONE(try_another(true));
    double before = std::numeric_limits<double>::infinity();
    // More directions remove noise alone.
    while (best.error() > wanted && best.error() <= 0.8 * before && !best.leaves_out(target.error) &&
           settings.bounces.directions * 4 <= most_directions) {
        before = best.error();
        settings.bounces.directions *= 4;
        rays.reset();
        HF_TRY_DONE(try_another(is_focused));
    }
    return best;
}

}  // namespace

Result<TargetBake> target_bake(const PointShading& direct, const ErrorTarget& target,
                               std::vector<DisplayedPoint> population, const Progress& progress) {
    TargetBake bake;
    RenderSettings settings = direct.settings;
    BakeErrorMeter meter(direct, population);
    HF_TRY(const DirectChoice chosen, chosen_direct_light(direct, target, meter, settings, progress));
    const auto lit = [&] {
        return chosen.shading(direct, settings, bake.indirect ? &*bake.indirect : nullptr);
    };
    bake.face_size = settings.face_size;
    bake.source_directions = settings.sources.direction_factor;
    bake.light_coefficients = settings.light_coefficients;
    PointShading shared = lit();
    shared.sharing = direct.sharing;
    HF_TRY(SceneRadiance radiance, scene_radiance(shared, progress));
    if (is_partial(direct.sharing)) return bake;
    BakeErrorMeter::Shading measured;
    bool stops_early = target.stops_early;
    if (settings.bounces.most > 0) {
        HF_TRY(IndirectChoice choice,
               chosen_indirect_light(lit(), target, population, radiance, meter, progress));
        settings.bounces.directions = bake.directions = choice.directions;
        stops_early = stops_early && !choice.leaves_out(target.error);
        bake.indirect = std::move(choice.light);
        bake.gathering_rays = bake.indirect->gathering_rays;
        measured = std::move(choice.measured);
    }
    meter = BakeErrorMeter(lit(), meter);
    if (!bake.indirect) {
        HF_TRY(measured, meter.shading_error(target.error, progress));
    }
    if (stops_early && root(measured.indirect.square) > stopping_share * target.error) {
        bake.end = SearchEnd::indirect_light;
        bake.is_stopped = true;
        return bake;
    }
    const VertexMask displayed = displayed_vertices(direct.scene, population);
    if (bake.indirect) HF_TRY_DONE(gather_irradiance(lit(), displayed, *bake.indirect, progress));
    const PointShading shading = lit();
    if (shading.indirect) HF_TRY_DONE(add_indirect_radiance(shading, radiance, progress));
    HF_TRY_DONE(Search(shading, target, meter, measured)(
        radiant_fine_meshes(direct.scene, std::move(radiance), shading.indirect), displayed, bake, progress));
    bake.is_stopped = stops_early && bake.end == SearchEnd::indirect_light;
    return bake;
}

Result<BakeError> vertex_bake_error(const PointShading& shading, const SceneRadiance& radiance,
                                    std::vector<DisplayedPoint> population, double accuracy,
                                    const Progress& progress) {
    BakeErrorMeter meter(shading, std::move(population));
    const auto bake = [&](const MeshPoint& at) -> BakeErrorMeter::Displayed {
        const std::vector<Outgoing>& values = radiance[at.instance];
        const auto& corners =
            shading.scene.entities[shading.scene.instances[at.instance].entity].mesh->triangles[at.triangle];
        return {interpolated(values, corners, at.weights()), corner_difference(values, corners) / 4};
    };
    HF_TRY(const BakeErrorMeter::Interpolation between, meter.reported_error(bake, 0, accuracy, progress));
    HF_TRY(const BakeErrorMeter::Shading measured, meter.shading_error(accuracy, progress));
    return meter.error(bake, between, measured);
}

}  // namespace haarfield
