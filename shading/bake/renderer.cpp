#include "shading/bake/renderer.h"

#include <memory>

#include "fields/base/parallel_loop.h"
#include "shading/scene/lighting.h"
#include "shading/scene/vertex_loop.h"
#include "shading/walk/vertex_shading.h"

namespace haarfield {
namespace {

/// Shades points, on one thread.
class PointShader {
public:
    explicit PointShader(const PointShading& shading)
        : shading_(shading), visibility_(shading.scene, shading.geometry) {}

    /// own  the tree of what the point sees of its own entity.
    Rgb operator()(std::size_t instance_index, const SurfacePoint& point,
                   const WideCubemap<std::uint8_t>& own) {
        const VertexView view = vertex_view(shading_.scene, shading_.scene.instances[instance_index], point);
        if (!visibility_.look(instance_index, own, view)) return Rgb(0.0f);
        return radiance(instance_index, point.material, view, visibility_.sight());
    }

    /// Of a vertex.
    Rgb operator()(std::size_t instance_index, std::uint32_t vertex) {
        const ShadedInstance& instance = shading_.scene.instances[instance_index];
        const SurfacePoint point = surface_point(shading_.scene.entities[instance.entity], vertex);
        const VertexSight* kept =
            shading_.visibility ? shading_.visibility->find(instance_index, vertex) : nullptr;
        if (!kept)
            return (*this)(instance_index, point,
                           shading_.geometry.entities[instance.entity].visibility.local(vertex));
        if (kept->trees.empty()) return Rgb(0.0f);
        return radiance(instance_index, point.material, vertex_view(shading_.scene, instance, point), *kept);
    }

private:
    Rgb radiance(std::size_t instance, std::uint16_t material, const VertexView& view,
                 const VertexSight& sight) {
        const auto& [scene, geometry, light, settings, kept] = shading_;
        const ShadedEntity& entity = scene.entities[scene.instances[instance].entity];
        const VertexBrdf brdf = vertex_brdf(entity.materials[material], view);
        return without_negative(outgoing_radiance(light, {geometry.directions, brdf, sight, settings.depth},
                                                  memory_, settings.tolerance));
    }

    const PointShading shading_;
    VertexVisibility visibility_;
    WalkMemory<std::uint8_t> memory_;
};

}  // namespace

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

Result<SceneRadiance> scene_radiance(const PointShading& shading, const Progress& progress) {
    const ShadedScene& scene = shading.scene;
    SceneRadiance radiance = black_vertices(scene);
    const Result<Done> visited = visit_vertices(
        scene, shading.geometry.orders(),
        [&]() -> VertexVisitor {
            return [&, shader = std::make_shared<PointShader>(shading)](std::size_t instance,
                                                                        std::uint32_t vertex) {
                radiance[instance][vertex] = (*shader)(instance, vertex);
            };
        },
        "shading", progress);
    if (!visited) return visited.error();
    for (std::size_t i = 0; i < radiance.size(); ++i)
        shading.geometry.entities[scene.instances[i].entity].fill(radiance[i]);
    return radiance;
}

Result<SceneRadiance> scene_radiance(const ShadedScene& scene, const RenderSettings& settings,
                                     const Progress& progress) {
    Result<ShadingGeometry> geometry = shading_geometry(scene, settings, progress);
    if (!geometry) return geometry.error();
    const LightPyramid light(
        lighting_tree(scene.environment, settings.face_size, {settings.light_coefficients}),
        settings.face_size);
    return scene_radiance({scene, *geometry, light, settings}, progress);
}

Result<std::vector<Rgb>> point_radiance(const PointShading& shading, std::span<const InstancePoint> points,
                                        const Progress& progress) {
    std::vector<Rgb> radiance(points.size());
    const Result<Done> shaded = parallel_loop(
        {points.size(), 64},
        [&]() -> LoopBody {
            return [&, shader = std::make_shared<PointShader>(shading),
                    seen = std::make_shared<SeenVisibility>(shading.settings.face_size)](std::size_t i) {
                const auto& [instance, point] = points[i];
                const ShadedEntity& entity = shading.scene.entities[shading.scene.instances[instance].entity];
                const OccluderView own{&entity.occlusion->own(), point.sample, &point.normal};
                radiance[i] = (*shader)(instance, point, (*seen)({&own, 1}));
            };
        },
        "shading", progress);
    if (!shaded) return shaded.error();
    return radiance;
}

}  // namespace haarfield
