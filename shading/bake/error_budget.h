#pragma once
/// The error budget: the error of each approximation of a bake alone, against the dense oracle.

#include <algorithm>
#include <cmath>

#include "shading/bake/mesh_point.h"
#include "shading/bake/renderer.h"

namespace haarfield {

/// The error of one approximation over a set of points.
struct BudgetEntry {
    std::string name, meaning;
    std::size_t points = 0;    ///< Number of points that the approximation affects.
    double relative_rmse = 0;  ///< RMS of the error over all points / RMS of the oracle's radiance.
    double relative_99 = 0;    ///< 99th percentile of the magnitude of the error / RMS radiance.
    double bias = 0;           ///< Mean error / mean of the oracle's radiance.
    double noise = 0;          ///< Standard error of a random oracle / RMS radiance.

    /// Estimates relative_rmse for an oracle without noise, because the squares of both errors add up.
    double without_noise() const {
        return std::sqrt(std::max(0.0, relative_rmse * relative_rmse - noise * noise));
    }
};

/// A measured vertex. If the settings have bounces, radiance includes the diffuse component of indirect
/// light.
struct BudgetVertex {
    std::uint32_t instance = 0, vertex = 0;
    Rgb exact{0.0f}, baked{0.0f};  ///< By the finest oracle, and by the bake. [W/(m^2 sr)]
    Rgb direct{0.0f};              ///< The direct light of `baked`. [W/(m^2 sr)]
    Rgb deviation{0.0f};           ///< Standard deviation of `exact` by path tracing. [W/(m^2 sr)]
};

/// The errors of all approximations of a bake.
struct ErrorBudget {
    std::vector<BudgetEntry> entries;    ///< Each approximation alone; the last entry has all of them.
    std::vector<BudgetVertex> vertices;  ///< The measured vertices, in descending order of their error.
    /// Vertices with an error above the sum of three terms: a fifth of their radiance, a hundredth of the RMS
    /// radiance of all vertices, and three standard deviations.
    std::vector<BudgetVertex> wrong;
};

/// Measures the errors at random unburied vertices, which are the same for each call.
///
/// Most approximations replace one component of the oracle; the error is the difference from the oracle. Such
/// components are truncated visibility, interpolated visibility, truncated lighting, lobes and cosines over
/// cells, and the traversal depth. The errors of the resolution and of coarse meshes are the differences
/// between the oracle and a finer one: with four times the texels along an edge (at most 256), or with the
/// original meshes. Bounces, and their absence, are compared with path tracing (path_tracer.h). The error of
/// bounces includes that of the reflected direct light.
///
/// originals   the original mesh of each entity: its occluder.
/// settings    of the bake.
/// vertices    number of vertices; all if there are fewer.
/// cost        about 20 ms per vertex. Path tracing adds up to 200 ms where light is hard to find. On all of
///             oneTBB's threads; the result does not depend on their number.
/// errors      interrupted.
Result<ErrorBudget> error_budget(const ShadedScene& scene, std::span<const Mesh* const> originals,
                                 const RenderSettings& settings, std::size_t vertices,
                                 const Progress& progress = {});

/// Compares the direct light of a bake with rays (ray_renderer.h), which share neither fields nor the
/// splitting of light into sources with the bake and its oracle. `noise` is the standard error of the rays,
/// from eight independent estimates per vertex.
///
/// vertices  ErrorBudget::vertices.
/// samples   number per vertex.
/// cost      about 0.2 us per sample.
/// errors    interrupted.
Result<BudgetEntry> ray_difference(const ShadedScene& scene, std::span<const BudgetVertex> vertices,
                                   std::uint32_t samples, const Progress& progress = {});

/// Measures the error of interpolation between vertices: the interpolated radiance of the oracle at the
/// corners of a triangle, minus the radiance of the oracle at the point. Buried points are left out.
///
/// cost    four evaluations of the oracle per point.
/// errors  interrupted.
Result<BudgetEntry> interpolation_error(const ShadedScene& scene, std::span<const MeshPoint> points,
                                        const RenderSettings& settings, const Progress& progress = {});

}  // namespace haarfield
