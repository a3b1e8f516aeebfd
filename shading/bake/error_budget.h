#pragma once
/// What each approximation of a bake costs, one at a time, against the dense oracle.

#include <algorithm>
#include <cmath>

#include "shading/bake/mesh_point.h"
#include "shading/bake/renderer.h"

namespace haarfield {

/// One approximation's error over some points.
struct BudgetEntry {
    std::string name, meaning;
    std::size_t points = 0;    ///< Where it acts.
    double relative_rmse = 0;  ///< RMS of the error over all points / RMS of the oracle's radiance.
    double relative_99 = 0;    ///< 99 % of all points err by at most this: magnitudes, relative to the RMS.
    double bias = 0;           ///< Mean error / mean of the oracle's radiance.
    double noise = 0;          ///< Standard error of a random oracle, relative as `relative_rmse`.

    /// The estimate of relative_rmse for an oracle without noise: the squares of both errors add up.
    double without_noise() const {
        return std::sqrt(std::max(0.0, relative_rmse * relative_rmse - noise * noise));
    }
};

/// A vertex, its radiance by the finest oracle, and by the bake; with light that bounces, if there are
/// bounces: of it the diffuse part.
struct BudgetVertex {
    std::uint32_t instance = 0, vertex = 0;
    Rgb exact{0.0f}, baked{0.0f};  ///< [W/(m^2 sr)]
    Rgb direct{0.0f};              ///< The direct light of `baked`. [W/(m^2 sr)]
    Rgb deviation{0.0f};           ///< Standard deviation of `exact`, where paths have found it.
};

/// What the approximations of a bake cost.
struct ErrorBudget {
    std::vector<BudgetEntry> entries;    ///< Each approximation alone; last all of them together.
    std::vector<BudgetVertex> vertices;  ///< That were measured; the worst first.
    /// Of these, those whose radiance errs by more than a fifth of what it is, plus a hundredth of its root
    /// mean square over all of them, plus three standard deviations.
    std::vector<BudgetVertex> wrong;
};

/// Measures at random vertices that are not buried, the same ones each time.
///
/// alone       the oracle with one part exchanged, less the oracle: visibility as the field's truncation
///             leaves it, or interpolated between exact samples; the lighting's truncated wavelets; lobes and
///             cosines as the walk evaluates them; a lesser depth. Resolution and coarse meshes the other way
///             round: the oracle, less a finer one (four times the texels along an edge, at most 256), or one
///             with the original meshes. Bounces: those of the settings, and none at all, against paths
///             (path_tracer.h); the first error includes what direct light errs where it is reflected.
/// originals   the mesh of each of the scene's entities as it was read: what of it blocks light.
/// settings    of the bake.
/// vertices    how many; all there are if these are fewer.
/// cost        some 20 ms a vertex, and up to 200 more for paths where light is hard to find, on all of
///             oneTBB's threads; the result does not depend on their number.
/// errors      interrupted.
Result<ErrorBudget> error_budget(const ShadedScene& scene, std::span<const Mesh* const> originals,
                                 const RenderSettings& settings, std::size_t vertices,
                                 const Progress& progress = {});

/// Compares the direct light of a bake with rays (ray_renderer.h), which share neither fields nor the
/// splitting of light into sources with the bake and its oracle. `noise` is the standard error of the rays,
/// from eight independent estimates per vertex.
///
/// vertices  of error_budget.
/// samples   of each vertex.
/// cost      some 0.2 us a sample.
/// errors    interrupted.
Result<BudgetEntry> ray_difference(const ShadedScene& scene, std::span<const BudgetVertex> vertices,
                                   std::uint32_t samples, const Progress& progress = {});

/// What interpolating between the vertices costs: the oracle's radiance at the corners, interpolated, less
/// the oracle at the point. Buried points are left out.
///
/// cost    four times the oracle's a point.
/// errors  interrupted.
Result<BudgetEntry> interpolation_error(const ShadedScene& scene, std::span<const MeshPoint> points,
                                        const RenderSettings& settings, const Progress& progress = {});

}  // namespace haarfield
