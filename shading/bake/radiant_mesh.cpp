#include "shading/bake/radiant_mesh.h"

#include <cassert>

#include "shading/visibility/placed_solids.h"

namespace haarfield {

std::optional<SurfacePoint> point_on(const Mesh& mesh, std::span<const std::uint32_t> triangles,
                                     const Vec3f& position, const Vec3f& normal,
                                     const LocalSampler& sampler) {
    VisibleMiddles middles;
    for (const std::uint32_t t : triangles) {
        const auto& [a, b, c] = mesh.triangles[t];
        if (const auto middle =
                sampler.visible_middle(mesh.positions[a], mesh.positions[b], mesh.positions[c]))
            middles.add(position, *middle);
    }
    if (middles.count == 0) return std::nullopt;
    return SurfacePoint{position, normal, sampler.sample(position, normal, middles),
                        mesh.vertex_materials[mesh.triangles[triangles.front()][0]]};
}

Result<std::vector<RadiantMesh>> mesh_radiance(const PointShading& shading, std::span<const Mesh> meshes,
                                               const Progress& progress) {
    std::vector<LocalSamples> samples;
    std::vector<std::vector<std::uint32_t>> orders;
    for (std::size_t e = 0; e < meshes.size(); ++e) {
        samples.push_back(local_samples(meshes[e], shading.scene.entities[e].occlusion->sampler()));
        orders.push_back(spatial_order(meshes[e].positions));
    }
    std::vector<InstancePoint> points;
    std::vector<RadiantMesh> result;
    const PlacedSolids solids(shading.scene);
    for (std::size_t i = 0; i < shading.scene.instances.size(); ++i) {
        const std::size_t e = shading.scene.instances[i].entity;
        RadiantMesh& shaded = result.emplace_back(
            RadiantMesh{meshes[e], std::vector<Outgoing>(meshes[e].positions.size()), samples[e]});
        shaded.samples.buried = solids.buried_vertices(shading.scene, i, meshes[e], samples[e]);
        for (const std::uint32_t v : orders[e]) {
            if (shaded.samples.buried[v]) continue;
            points.push_back({i,
                              {meshes[e].positions[v], meshes[e].normals[v], samples[e].points[v],
                               meshes[e].vertex_materials[v]}});
        }
    }
    HF_TRY(const std::vector<Outgoing> radiance, point_radiance(shading, points, progress));

    auto next = radiance.begin();
    for (std::size_t i = 0; i < result.size(); ++i) {
        RadiantMesh& shaded = result[i];
        for (const std::uint32_t v : orders[shading.scene.instances[i].entity])
            if (!shaded.samples.buried[v]) shaded.radiance[v] = *next++;
        BuriedFill(shaded.mesh, shaded.samples.buried)(shaded.radiance);
    }
    return result;
}

Result<SceneRadiance> vertex_radiance(const PointShading& shading, std::span<const SampledMesh> meshes,
                                      const VertexMask& wanted, const Progress& progress) {
    return vertex_values(shading.scene, meshes, wanted, [&](std::span<const InstancePoint> points) {
        return point_radiance(shading, points, progress);
    });
}

Result<SceneRadiance> vertex_values(const ShadedScene& scene, std::span<const SampledMesh> meshes,
                                    const VertexMask& wanted, const PointRadiance& radiance_of) {
    assert(meshes.size() == scene.instances.size());
    SceneRadiance result;
    std::vector<InstancePoint> points;
    std::vector<std::uint32_t> vertices;
    std::vector<std::vector<std::uint8_t>> buried;
    const PlacedSolids solids(scene);
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const Mesh& mesh = *meshes[i].mesh;
        const std::vector<Vec3f>& from = meshes[i].samples->points;
        buried.push_back(solids.buried_vertices(scene, i, mesh, *meshes[i].samples));
        assert(from.size() == mesh.positions.size());
        result.emplace_back(mesh.positions.size());
        for (const std::uint32_t v : spatial_order(mesh.positions)) {
            if (buried[i][v] || !(wanted.empty() || wanted[i][v])) continue;
            points.push_back({i, {mesh.positions[v], mesh.normals[v], from[v], mesh.vertex_materials[v]}});
            vertices.push_back(v);
        }
    }
    HF_TRY(const std::vector<Outgoing> radiance, radiance_of(points));
    for (std::size_t k = 0; k < points.size(); ++k) result[points[k].instance][vertices[k]] = radiance[k];
    for (std::size_t i = 0; i < meshes.size(); ++i) BuriedFill(*meshes[i].mesh, buried[i])(result[i]);
    return result;
}

}  // namespace haarfield
