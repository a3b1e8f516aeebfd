#include "bridge/scene_budget.h"

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

std::vector<PreviewInstance> preview_instances(const ShadedScene& scene, const SceneRadiance& radiance) {
    std::vector<PreviewInstance> instances;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ShadedInstance& instance = scene.instances[i];
        instances.push_back({scene.entities[instance.entity].mesh, instance.placement, radiance[i]});
    }
    return instances;
}

Result<SceneBudget> scene_budget(const Scene& scene, const SceneEntities& entities, const ShadedScene& shaded,
                                 const RenderSettings& settings, std::size_t points, Preview& preview,
                                 const Progress& progress, std::uint32_t ray_samples) {
    std::vector<const Mesh*> originals;
    for (const auto& entity : entities.entities) originals.push_back(&blocking_surface(entity->mesh));
    Result<ErrorBudget> budget = error_budget(shaded, originals, settings, points, progress);
    if (!budget) return budget.error();
    Result<SceneRadiance> radiance = scene_radiance(shaded, settings, progress);
    if (!radiance) return radiance.error();
    SceneBudget result{std::move(budget->entries),
                       std::move(budget->vertices),
                       std::move(budget->wrong),
                       std::move(*radiance),
                       {}};
    result.pixels = preview.points(scene.camera, preview_instances(shaded, result.radiance));
    const Result<BudgetEntry> interpolation =
        interpolation_error(shaded, random_points(result.pixels, points), settings, progress);
    if (!interpolation) return interpolation.error();
    result.entries.push_back(*interpolation);
    const Result<BudgetEntry> rays = ray_difference(shaded, result.vertices, ray_samples, progress);
    if (!rays) return rays.error();
    result.entries.push_back(*rays);
    return result;
}

}  // namespace haarfield
