#pragma once
/// The error budget of a scene: of its vertices, and of what lies between them in the picture.

#include "bridge/preview.h"
#include "scenes/scene_entities.h"
#include "shading/bake/error_budget.h"

namespace haarfield {

/// A budget, and what it was measured on.
struct SceneBudget {
    std::vector<BudgetEntry> entries;              ///< Those of error_budget, then of interpolation, of rays.
    std::vector<BudgetVertex> vertices, wrong;     ///< As error_budget has them.
    SceneRadiance radiance;                        ///< Of the bake, by instance.
    std::vector<std::optional<MeshPoint>> pixels;  ///< What the camera's pixels show.
};

/// Instances of a scene as the preview takes them. `scene` and `radiance` must outlive the result.
std::vector<PreviewInstance> preview_instances(const ShadedScene& scene, const SceneRadiance& radiance);

/// What each approximation of a bake costs alone: error_budget, and interpolation_error at random pixels.
///
/// scene    its camera's place is known.
/// points   random vertices, and pixels, at most.
/// preview  looks for the pixels.
/// ray_samples  those of ray_difference.
/// errors   interrupted.
Result<SceneBudget> scene_budget(const Scene& scene, const SceneEntities& entities, const ShadedScene& shaded,
                                 const RenderSettings& settings, std::size_t points, Preview& preview,
                                 const Progress& progress = {}, std::uint32_t ray_samples = 4096);

}  // namespace haarfield
