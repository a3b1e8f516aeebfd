#include "shading/dense_renderer.h"

#include <memory>

#include "fields/visibility_rasterizer.h"
#include "shading/lighting.h"
#include "shading/vertex_loop.h"

namespace haarfield {
namespace {

struct DenseFrame {
    const ShadedScene& scene;
    std::vector<Rgb> light;         ///< lighting.h: radiance * solid angle * size^2, by texel.
    std::vector<Vec3f> directions;  ///< Of the texels' centres.
};

struct DenseWorker {
    VisibilityRasterizer rasterizer;
    std::vector<float> visibility;

    explicit DenseWorker(int face_size) : rasterizer(face_size) {}

    void multiply(std::span<const std::uint8_t> open) {
        for (std::size_t i = 0; i < visibility.size(); ++i)
            visibility[i] *= static_cast<float>(open[i]) / samples_per_texel;
    }
};

Rgb dense_vertex(const DenseFrame& frame, std::size_t instance_index, std::uint32_t vertex,
                 DenseWorker& worker) {
    const ShadedScene& scene = frame.scene;
    const ShadedInstance& instance = scene.instances[instance_index];
    const ShadedEntity& entity = scene.entities[instance.entity];
    const Material& material = entity.materials[entity.mesh->vertex_materials[vertex]];
    const VertexView view = vertex_view(scene, instance, vertex);

    worker.visibility.assign(frame.directions.size(), 1.0f);
    worker.multiply(worker.rasterizer.open_samples(entity.occlusion->own(),
                                                   entity.occlusion->samples().points[vertex], &view.normal));
    for (std::size_t other = 0; other < scene.instances.size(); ++other) {
        if (other == instance_index) continue;
        const EntityOcclusion& occlusion = *scene.entities[scene.instances[other].entity].occlusion;
        const Vec3f point = (view.point - scene.instances[other].translate) / scene.instances[other].scale;
        if (occlusion.in_coarse()(point)) return Rgb(0.0f);
        worker.multiply(worker.rasterizer.open_samples(occlusion.coarse(), point));
    }

    const Vec3d normal(view.normal), mirror(view.mirror);
    Vec3d radiance(0.0);
    for (std::size_t i = 0; i < frame.directions.size(); ++i)
        if (worker.visibility[i] > 0)
            radiance += Vec3d(frame.light[i]) * double(worker.visibility[i]) *
                        reflectance(material, normal, mirror, Vec3d(frame.directions[i]));
    // light holds size^2, for integrals over the unit square of each face.
    return Rgb(Vec3f(radiance / (double(frame.directions.size()) / cubemap_faces)));
}

}  // namespace

Result<std::vector<std::vector<Rgb>>> dense_vertex_radiance(const ShadedScene& scene,
                                                            const RenderSettings& settings,
                                                            const Progress& progress) {
    const DenseFrame frame{scene, lighting_texels(scene.environment, settings.face_size),
                           texel_directions(settings.face_size)};
    std::vector<std::vector<std::uint32_t>> orders;
    for (const ShadedEntity& entity : scene.entities) orders.push_back(spatial_order(entity.mesh->positions));
    const std::vector<std::span<const std::uint32_t>> order_spans(orders.begin(), orders.end());
    return shaded_vertices(
        scene, order_spans,
        [&]() -> VertexShader {
            return [&frame, worker = std::make_shared<DenseWorker>(settings.face_size)](
                       std::size_t instance, std::uint32_t vertex) {
                return dense_vertex(frame, instance, vertex, *worker);
            };
        },
        progress);
}

}  // namespace haarfield
