#include "shading/bake/dense_renderer.h"

#include <memory>

#include "shading/scene/lighting.h"
#include "shading/visibility/buried_fill.h"

namespace haarfield {

DenseLight::DenseLight(const LatLongImage& environment, int size)
    : face_size(size), light(lighting_texels(environment, size)), directions(texel_directions(size)) {}

Vec3d DenseLight::radiance_from(std::size_t texel, const Material& material, const VertexView& view) const {
    // light holds size^2, for integrals over the unit square of each face.
    const double texels_a_face = double(face_size) * face_size;
    return Vec3d(light[texel]) *
           reflectance(material, Vec3d(view.normal), Vec3d(view.mirror), Vec3d(directions[texel])) /
           texels_a_face;
}

void multiply_by_open(std::span<float> visibility, std::span<const std::uint8_t> open_samples) {
    for (std::size_t i = 0; i < visibility.size(); ++i) visibility[i] *= open_fraction(open_samples[i]);
}

DenseShader::DenseShader(const ShadedScene& scene, const DenseLight& light)
    : scene_(scene), light_(light), rasterizer_(light.face_size) {}

Rgb DenseShader::radiance(std::size_t instance, const SurfacePoint& point) {
    return radiance(instance, point, vertex_view(scene_, scene_.instances[instance], point));
}

Rgb DenseShader::radiance(std::size_t instance, const SurfacePoint& point, const VertexView& view) {
    const ShadedEntity& entity = scene_.entities[scene_.instances[instance].entity];
    visibility_.assign(light_.directions.size(), 1.0f);
    multiply_by_open(visibility_,
                     rasterizer_.open_samples(entity.occlusion->own(), point.sample, &view.normal));
    for (std::size_t other = 0; other < scene_.instances.size(); ++other) {
        if (other == instance) continue;
        const EntityOcclusion& occlusion = *scene_.entities[scene_.instances[other].entity].occlusion;
        const Vec3f from = scene_.instances[other].placement.point_to_object(view.point);
        if (occlusion.in_coarse()(from)) return Rgb(0.0f);
        multiply_by_open(visibility_, rasterizer_.open_samples(occlusion.coarse(), from));
    }
    Vec3d radiance(0.0);
    for (std::size_t i = 0; i < visibility_.size(); ++i)
        if (visibility_[i] > 0)
            radiance +=
                light_.radiance_from(i, entity.materials[point.material], view) * double(visibility_[i]);
    return Rgb(Vec3f(radiance));
}

Result<SceneRadiance> dense_scene_radiance(const ShadedScene& scene, const RenderSettings& settings,
                                           const Progress& progress) {
    const DenseLight light(scene.environment, settings.face_size);
    std::vector<std::vector<std::uint32_t>> orders;
    for (const ShadedEntity& entity : scene.entities) orders.push_back(spatial_order(entity.mesh->positions));
    const std::vector<std::span<const std::uint32_t>> order_spans(orders.begin(), orders.end());
    SceneRadiance radiance = black_vertices(scene);
    const Result<Done> visited = visit_vertices(
        scene, order_spans,
        [&]() -> VertexVisitor {
            return [&, shader = std::make_shared<DenseShader>(scene, light)](std::size_t instance,
                                                                             std::uint32_t vertex) {
                radiance[instance][vertex] = shader->radiance(
                    instance, surface_point(scene.entities[scene.instances[instance].entity], vertex));
            };
        },
        "shading", progress);
    if (!visited) return visited.error();
    for (std::size_t i = 0; i < radiance.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        BuriedFill(*entity.mesh, entity.occlusion->samples().buried)(radiance[i]);
    }
    return radiance;
}

}  // namespace haarfield
