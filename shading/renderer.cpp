#include "shading/renderer.h"

#include <memory>

#include "shading/lighting.h"
#include "shading/vertex_loop.h"
#include "shading/vertex_shading.h"

namespace haarfield {
VertexBrdf vertex_brdf(const Material& material, const VertexView& view) {
    const float over_pi = static_cast<float>(1 / pi);
    VertexBrdf brdf;
    brdf.normal = view.normal;
    brdf.mirror = view.mirror;
    brdf.diffuse = material.diffuse * over_pi;
    brdf.specular = material.specular * over_pi;
    brdf.shininess = material.shininess;
    brdf.cosine_weighted = material.convention == LobeConvention::physical;
    if (brdf.cosine_weighted) {
        brdf.specular *= (material.shininess + 2) * 0.5f;
    } else {
        brdf.phong = material.phong;
        brdf.blinn = material.blinn;
        brdf.blinn_exponent = 1 / material.roughness;
        brdf.metallic = (Rgb(1.0f) - material.pigment) * material.metallic;
    }
    return brdf;
}

Result<std::vector<std::vector<Rgb>>> vertex_radiance(const ShadedScene& scene,
                                                      const ShadingGeometry& geometry,
                                                      const LightPyramid& light,
                                                      const RenderSettings& settings,
                                                      const Progress& progress) {
    struct Worker {
        VertexVisibility visibility;
        WalkMemory<std::uint8_t> memory;
    };
    const auto make_shader = [&]() -> VertexShader {
        return [&, worker = std::make_shared<Worker>(Worker{VertexVisibility(scene, geometry), {}})](
                   std::size_t instance, std::uint32_t vertex) {
            const ShadedEntity& entity = scene.entities[scene.instances[instance].entity];
            const Material& material = entity.materials[entity.mesh->vertex_materials[vertex]];
            const VertexView view = vertex_view(scene, scene.instances[instance], vertex);
            if (!worker->visibility.look(instance, vertex, view)) return Rgb(0.0f);
            const Rgb radiance = vertex_radiance(light, geometry.directions, vertex_brdf(material, view),
                                                 worker->visibility.cones(), worker->visibility.trees(),
                                                 settings.depth, worker->memory, settings.tolerance);
            return Rgb(std::max(radiance.x, 0.0f), std::max(radiance.y, 0.0f), std::max(radiance.z, 0.0f));
        };
    };
    std::vector<std::span<const std::uint32_t>> orders;
    for (const ShadingGeometry::Entity& entity : geometry.entities) orders.push_back(entity.order);
    return shaded_vertices(scene, orders, make_shader, progress);
}

Result<std::vector<std::vector<Rgb>>> vertex_radiance(const ShadedScene& scene,
                                                      const RenderSettings& settings,
                                                      const Progress& progress) {
    Result<ShadingGeometry> geometry = shading_geometry(scene, settings, progress);
    if (!geometry) return geometry.error();
    const LightPyramid light(
        lighting_tree(scene.environment, settings.face_size, {settings.light_coefficients}),
        settings.face_size);
    return vertex_radiance(scene, *geometry, light, settings, progress);
}

}  // namespace haarfield
