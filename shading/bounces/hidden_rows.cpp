#include "shading/bounces/hidden_rows.h"

#include "shading/visibility/placed_solids.h"

namespace haarfield {

std::vector<std::uint8_t> hidden_rows(const ShadedScene& scene, const ShadingGeometry& geometry) {
    const PlacedSolids solids(scene);
    const VertexRows rows(scene, geometry);
    std::vector<std::uint8_t> result;
    result.reserve(rows.count());
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        const std::vector<std::uint8_t> buried =
            solids.buried_vertices(scene, i, *entity.mesh, entity.occlusion->samples());
        for (const std::uint32_t v : rows.vertices(i)) result.push_back(buried[v]);
    }
    return result;
}

std::array<float, 3> open_weights(const SurfaceHit& hit, const std::array<std::uint32_t, 3>& corners,
                                  std::span<const std::uint8_t> hidden) {
    std::array<float, 3> weights = hit.weights();
    for (std::size_t k = 0; k < 3; ++k)
        if (hidden[corners[k]]) weights[k] = 0;
    return weights;
}

}  // namespace haarfield
