#include "scenes/scene_budget.h"

#include "fields/base/random_choice.h"

namespace haarfield {
namespace {

std::vector<MeshPoint> random_points(const std::vector<std::optional<MeshPoint>>& pixels,
                                     std::size_t wanted) {
    std::vector<MeshPoint> points;
    for (const std::optional<MeshPoint>& pixel : pixels)
        if (pixel) points.push_back(*pixel);
    keep_random(points, wanted);
    return points;
}

}  // namespace

Result<SceneBudget> scene_budget(const SceneEntities& entities, const ShadedScene& shaded,
                                 const RenderSettings& settings, std::size_t points,
                                 const std::vector<std::optional<MeshPoint>>& pixels,
                                 const Progress& progress, std::uint32_t ray_samples) {
    std::vector<const Mesh*> originals;
    for (const auto& entity : entities.entities) originals.push_back(&blocking_surface(entity->mesh));
    HF_TRY(ErrorBudget budget, error_budget(shaded, originals, settings, points, progress));
    HF_TRY(SceneRadiance radiance, scene_radiance(shaded, settings, progress));
    SceneBudget result{std::move(budget.entries), std::move(budget.vertices), std::move(budget.wrong),
                       total(radiance)};
    HF_TRY(const BudgetEntry interpolation,
           interpolation_error(shaded, random_points(pixels, points), settings, progress));
    result.entries.push_back(interpolation);
    HF_TRY(const BudgetEntry rays, ray_difference(shaded, result.vertices, ray_samples, progress));
    result.entries.push_back(rays);
    return result;
}

}  // namespace haarfield
