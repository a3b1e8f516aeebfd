#pragma once
/// Measures the error budget of a scene: at its vertices, and between them in the picture.

#include "scenes/scene_entities.h"
#include "shading/bake/error_budget.h"

namespace haarfield {

/// An error budget, and the vertices and the radiance at which it was measured.
struct SceneBudget {
    std::vector<BudgetEntry> entries;           ///< Those of error_budget, then interpolation, then rays.
    std::vector<BudgetVertex> vertices, wrong;  ///< As in ErrorBudget.
    SceneColours radiance;                      ///< Of the bake, by instance.
};

/// Measures the error of each approximation alone: error_budget, and interpolation_error at random pixels.
///
/// points       maximum number of random vertices, and of random pixels.
/// pixels       the visible points at the camera's pixels: Preview::points.
/// ray_samples  those of ray_difference.
/// errors       interrupted.
Result<SceneBudget> scene_budget(const SceneEntities& entities, const ShadedScene& shaded,
                                 const RenderSettings& settings, std::size_t points,
                                 const std::vector<std::optional<MeshPoint>>& pixels,
                                 const Progress& progress = {}, std::uint32_t ray_samples = 4096);

}  // namespace haarfield
