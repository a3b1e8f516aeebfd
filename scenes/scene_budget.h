#pragma once
/// The error budget of a scene: of its vertices, and of what lies between them in the picture.

#include "scenes/scene_entities.h"
#include "shading/bake/error_budget.h"

namespace haarfield {

/// A budget, and the vertices and the radiance that it was measured on.
struct SceneBudget {
    std::vector<BudgetEntry> entries;           ///< Those of error_budget, then of interpolation, of rays.
    std::vector<BudgetVertex> vertices, wrong;  ///< As error_budget has them.
    SceneColours radiance;                      ///< Of the bake, by instance.
};

/// Measures the error of each approximation alone: error_budget, and interpolation_error at random pixels.
///
/// points       random vertices, and pixels, at most.
/// pixels       the points that the camera's pixels show: Preview::points.
/// ray_samples  those of ray_difference.
/// errors       interrupted.
Result<SceneBudget> scene_budget(const SceneEntities& entities, const ShadedScene& shaded,
                                 const RenderSettings& settings, std::size_t points,
                                 const std::vector<std::optional<MeshPoint>>& pixels,
                                 const Progress& progress = {}, std::uint32_t ray_samples = 4096);

}  // namespace haarfield
