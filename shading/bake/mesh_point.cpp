#include "shading/bake/mesh_point.h"

namespace haarfield {

std::optional<SurfacePoint> surface_point(const ShadedEntity& entity, const MeshPoint& at) {
    const Mesh& mesh = *entity.mesh;
    const auto& corners = mesh.triangles[at.triangle];
    const std::array<float, 3> weights = at.weights();
    SurfacePoint point{Vec3f(0.0f), Vec3f(0.0f), Vec3f(0.0f), mesh.vertex_materials[corners[0]]};
    for (std::size_t c = 0; c < 3; ++c) {
        if (entity.occlusion->samples().buried[corners[c]]) return std::nullopt;
        point.position += mesh.positions[corners[c]] * weights[c];
        point.normal += mesh.normals[corners[c]] * weights[c];
    }
    const LocalSampler& sampler = entity.occlusion->sampler();
    const std::optional<Vec3f> middle = sampler.visible_middle(
        mesh.positions[corners[0]], mesh.positions[corners[1]], mesh.positions[corners[2]]);
    if (!middle) return std::nullopt;
    point.normal.normalize();
    point.sample = sampler.sample(point.position, point.normal, {point.position, *middle, 1});
    return point;
}

}  // namespace haarfield
