#include "shading/bake/dense_renderer.h"

#include <memory>

#include "shading/bake/emitter_light.h"
#include "shading/bake/lamp_light.h"
#include "shading/bake/vertex_evaluation.h"
#include "shading/scene/lighting.h"

namespace haarfield {

DenseLight::DenseLight(const Environment& environment, int size, const SourceRule& rule)
    : face_size(size), directions(texel_directions(size)) {
    const SplitLight split = split_light(environment, rule);
    light = lighting_texels(split.smooth, size);
    for (const LightSource& source : split.sources)
        parts.insert(parts.end(), source.parts.begin(), source.parts.end());
}

Components<Vec3d> DenseLight::radiance_from(std::size_t texel, const Material& material,
                                            const ShadingPoint& at) const {
    // `light` contains size^2, for integrals over the unit square of each face.
    const double texels_a_face = double(face_size) * face_size;
    return reflectance(material, Vec3d(at.brdf.normal), Vec3d(at.brdf.mirror), Vec3d(directions[texel])) *
           Vec3d(light[texel]) / texels_a_face;
}

void multiply_by_open(std::span<float> visibility, std::span<const std::uint8_t> open_samples) {
    for (std::size_t i = 0; i < visibility.size(); ++i) visibility[i] *= open_fraction(open_samples[i]);
}

Components<Vec3d> radiance_from_parts(std::span<const DirectionalLight> parts, const ShadowRays& rays,
                                      const Material& material, const ShadingPoint& at) {
    Components<Vec3d> radiance;
    for (const DirectionalLight& part : parts)
        if (part.direction.dot(at.brdf.normal) > 0 && !rays.is_blocked(at.from, part.direction))
            radiance +=
                reflectance(material, Vec3d(at.brdf.normal), Vec3d(at.brdf.mirror), Vec3d(part.direction)) *
                Vec3d(part.irradiance);
    return radiance;
}

Components<Vec3d> radiance_from_near(std::span<const PlacedLamp> lamps, const EmitterTree& emitters,
                                     const ShadowRays& rays, const Material& material,
                                     const ShadingPoint& at) {
    Outgoing by_emitters;
    add_emitter_light(rays, emitters, {&at, 1}, {&by_emitters, 1}, fine_emitter_cut);
    return radiance_from_lamps(lamps, rays, material, at) + Components<Vec3d>(by_emitters);
}

DenseScene::DenseScene(const ShadedScene& of, int face_size, const SourceRule& rule)
    : scene(of),
      light(of.environment, face_size, rule),
      lamps(placed_lamps(of.lamps)),
      emitters(scene_emitters(of)) {
    rays.build(scene);
}

DenseShader::DenseShader(const DenseScene& dense) : dense_(dense), rasterizer_(dense.light.face_size) {}

Outgoing DenseShader::radiance(std::size_t instance, const SurfacePoint& point) {
    return radiance(instance, point, shading_point(dense_.scene, dense_.scene.instances[instance], point));
}

Outgoing DenseShader::radiance(std::size_t instance, const SurfacePoint& point, const ShadingPoint& at) {
    const auto& [scene, light, rays, lamps, emitters] = dense_;
    const ShadedInstance& placed = scene.instances[instance];
    const ShadedEntity& entity = scene.entities[placed.entity];
    visibility_.assign(light.directions.size(), 1.0f);
    multiply_by_open(visibility_, rasterizer_.open_samples(own_view(scene, instance, point.sample, at)));
    for (std::size_t other = 0; other < scene.instances.size(); ++other) {
        if (other == instance) continue;
        const Placement& placement = scene.instances[other].placement;
        const EntityOcclusion& occlusion = *scene.entities[scene.instances[other].entity].occlusion;
        if (occlusion.in_coarse()(placement.point_to_object(at.outside))) return {};
        multiply_by_open(visibility_, rasterizer_.open_samples(view_of(scene, other, at)));
    }
    Components<Vec3d> radiance;
    for (std::size_t i = 0; i < visibility_.size(); ++i)
        if (visibility_[i] > 0)
            radiance += light.radiance_from(i, entity.materials[point.material], at) * double(visibility_[i]);
    const Material& material = entity.materials[point.material];
    radiance += radiance_from_parts(light.parts, rays, material, at);
    radiance += radiance_from_near(lamps, emitters, rays, material, at);
    return Outgoing(radiance);
}

Result<SceneRadiance> dense_scene_radiance(const ShadedScene& scene, const RenderSettings& settings,
                                           const Progress& progress, const PointSharing* sharing) {
    const DenseScene dense(scene, settings.face_size, settings.sources);
    return evaluated_vertices(
        scene,
        [&]() -> VertexEvaluation {
            return [&, shader = std::make_shared<DenseShader>(dense)](std::size_t instance,
                                                                      std::uint32_t vertex) {
                const ShadedEntity& entity = scene.entities[scene.instances[instance].entity];
                return shader->radiance(instance, surface_point(entity, vertex));
            };
        },
        progress, sharing);
}

}  // namespace haarfield
