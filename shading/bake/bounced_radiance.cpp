#include "shading/bake/bounced_radiance.h"

#include <algorithm>
#include <cassert>

#include "fields/base/parallel_loop.h"
#include "shading/scene/vertex_loop.h"
#include "shading/visibility/placed_solids.h"
#include "shading/visibility/vertex_rows.h"

namespace haarfield {
namespace {

Outgoing outgoing(const PointShading& shading, std::size_t instance, const SurfacePoint& point,
                  const Rgb& irradiance) {
    const ShadingPoint at = shading_point(shading.scene, shading.scene.instances[instance], point);
    return shading.indirect->outgoing(shading.scene, at.from, at.brdf, irradiance);
}

std::shared_ptr<const FineSurface> placed_surface(const ShadedScene& scene, const BounceRays* before) {
    if (!before) return std::make_shared<const FineSurface>(scene);
    const auto surface = std::make_shared<FineSurface>(*before->surface);
    surface->place(scene);
    return surface;
}

}  // namespace

Result<BounceRays> bounce_rays(const ShadedScene& scene, const ShadingGeometry& geometry,
                               const RenderSettings& settings, const Progress& progress,
                               const BounceRays* before) {
    const std::shared_ptr<const FineSurface> surface = placed_surface(scene, before);
    if (progress.stop.stop_requested()) return interruption();
    HF_TRY(LightTransport transport,
           LightTransport::make(scene, geometry, *surface, settings.bounces.directions, progress));
    return BounceRays{surface, std::move(transport)};
}

std::vector<Rgb> tinted_rows(const ShadedScene& scene, const VertexRows& rows, std::vector<Rgb> diffuse) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::span<const Rgb> tints = scene.entities[scene.instances[i].entity].tints;
        for (std::size_t k = 0; k < tints.size(); ++k)
            diffuse[rows.first(i) + k] *= tints[rows.vertices(i)[k]];
    }
    return diffuse;
}

Result<IndirectLight> scene_indirect_light(const PointShading& direct, const SceneRadiance& radiance,
                                           const BounceRays& rays, const Progress& progress) {
    const VertexRows rows(direct.scene, direct.geometry);
    const BounceSettings& bounces = direct.settings.bounces;
    const std::vector<Rgb> by_row =
                               tinted_rows(direct.scene, rows, row_values(rows, diffuse_component(radiance))),
                           reflectances = row_reflectances(direct.scene, direct.geometry);
    LightTransport transport = rays.transport;
    Result<BouncedLight> bounced = bounced_light(transport, reflectances, by_row, bounces, progress);
    if (!bounced) return bounced.error();
    HF_TRY_DONE(transport.refine(direct.scene, direct.geometry, *rays.surface, bounced->radiance,
                                 reflectances, progress));
    bounced = bounced_light(transport, reflectances, by_row, bounces, progress);
    if (!bounced) return bounced.error();
    return indirect_light(direct.scene, direct.geometry, rays.surface, transport, std::move(*bounced));
}

Result<IndirectLight> scene_indirect_light(const PointShading& direct, const SceneRadiance& radiance,
                                           const Progress& progress) {
    HF_TRY(const BounceRays rays, bounce_rays(direct.scene, direct.geometry, direct.settings, progress));
    return scene_indirect_light(direct, radiance, rays, progress);
}

Result<IndirectLight> scene_indirect_light(const PointShading& direct, const Progress& progress) {
    HF_TRY(const SceneRadiance radiance, scene_radiance(direct, progress));
    return scene_indirect_light(direct, radiance, progress);
}

Result<SceneRadiance> bounced_radiance(const PointShading& direct, std::optional<IndirectLight>& indirect,
                                       const Progress& progress) {
    assert(!direct.indirect);
    indirect.reset();
    Result<SceneRadiance> radiance = scene_radiance(direct, progress);
    if (!radiance || is_partial(direct.sharing)) return radiance;
    const PlacedFill fill(direct.scene);
    if (direct.settings.bounces.most == 0) {
        fill(*radiance);
        return radiance;
    }
    HF_TRY(indirect, scene_indirect_light(direct, *radiance, progress));
    PointShading lit = direct;
    lit.indirect = &*indirect;
    HF_TRY_DONE(add_indirect_radiance(lit, *radiance, progress));
    fill(*radiance);
    return radiance;
}

Result<std::vector<Outgoing>> indirect_radiance(const PointShading& shading,
                                                std::span<const InstancePoint> points,
                                                const Progress& progress) {
    assert(shading.indirect);
    std::vector<Outgoing> result(points.size());
    HF_TRY_DONE(parallel_loop(
        {points.size(), 64},
        [&]() -> LoopBody {
            return [&](std::size_t k) {
                const auto& [instance, point, ignored] = points[k];
                result[k] = outgoing(shading, instance, point,
                                     shading.indirect->irradiance_at(shading.scene, instance, point));
            };
        },
        "indirect light", progress));
    return result;
}

Result<Done> gather_irradiance(const PointShading& direct, const VertexMask& wanted, IndirectLight& indirect,
                               const Progress& progress) {
    const ShadedScene& scene = direct.scene;
    indirect.nearness.clear();
    for (const std::vector<Rgb>& values : indirect.irradiance)
        indirect.nearness.emplace_back(values.size(), GatheredIrradiance().nearness);
    return visit_vertices(
        scene, direct.geometry.orders(),
        [&]() -> VertexVisitor {
            return [&](std::size_t instance, std::uint32_t vertex) {
                if (!wanted[instance][vertex]) return;
                const GatheredIrradiance found = indirect.gathered_at(
                    scene, instance, surface_point(scene.entities[scene.instances[instance].entity], vertex));
                indirect.irradiance[instance][vertex] = found.irradiance;
                indirect.nearness[instance][vertex] = found.nearness;
            };
        },
        "indirect light", progress);
}

Result<Done> add_indirect_radiance(const PointShading& shading, SceneRadiance& radiance,
                                   const Progress& progress) {
    assert(shading.indirect);
    const ShadedScene& scene = shading.scene;
    HF_TRY_DONE(visit_vertices(
        scene, shading.geometry.orders(),
        [&]() -> VertexVisitor {
            return [&](std::size_t instance, std::uint32_t vertex) {
                radiance[instance][vertex] +=
                    outgoing(shading, instance,
                             surface_point(scene.entities[scene.instances[instance].entity], vertex),
                             shading.indirect->irradiance[instance][vertex]);
            };
        },
        "indirect light", progress));
    for (std::size_t i = 0; i < radiance.size(); ++i)
        shading.geometry.entities[scene.instances[i].entity].fill(radiance[i]);
    return Done{};
}

}  // namespace haarfield
