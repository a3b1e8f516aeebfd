#include "shading/bake/vertex_evaluation.h"

#include "shading/visibility/placed_solids.h"

namespace haarfield {

Result<SceneRadiance> evaluated_vertices(const ShadedScene& scene,
                                         const std::function<VertexEvaluation()>& make,
                                         const Progress& progress, const PointSharing* sharing) {
    std::vector<std::vector<std::uint32_t>> orders;
    for (const ShadedEntity& entity : scene.entities) orders.push_back(spatial_order(entity.mesh->positions));
    const std::vector<std::span<const std::uint32_t>> order_spans(orders.begin(), orders.end());
    SceneRadiance radiance;
    const auto shade = [&](const VertexMask* wanted) {
        return visit_wanted_runs(
            scene, order_spans, wanted,
            [&, wanted]() -> VertexRunVisitor {
                return [&, wanted, evaluate = make()](std::size_t instance,
                                                      std::span<const std::uint32_t> vertices) {
                    for (const std::uint32_t vertex : vertices) {
                        if (progress.stop.stop_requested()) return;
                        if (!wanted || (*wanted)[instance][vertex] != 0)
                            radiance[instance][vertex] = evaluate(instance, vertex);
                    }
                };
            },
            "shading", progress);
    };
    HF_TRY_DONE(share_vertices(sharing, scene, order_spans, radiance, shade));
    if (is_partial(sharing)) return radiance;
    const PlacedSolids solids(scene);
    for (std::size_t i = 0; i < radiance.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        BuriedFill(*entity.mesh,
                   solids.buried_vertices(scene, i, *entity.mesh, entity.occlusion->samples()))(radiance[i]);
    }
    return radiance;
}

}  // namespace haarfield
