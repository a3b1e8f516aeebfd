#include "shading/bake/render_passes.h"

#include <algorithm>
#include <cassert>
#include <optional>

#include "shading/bake/bounced_radiance.h"
#include "shading/bake/colour_fit.h"
#include "shading/bake/dense_renderer.h"
#include "shading/bake/ray_renderer.h"

namespace haarfield {
namespace {

/// Returns a diffuse material of albedo 1.
Material white_paint() {
    Material white;
    white.diffuse = Rgb(1.0f);
    return white;
}

ShadedScene in_white_paint(ShadedScene scene) {
    for (ShadedEntity& entity : scene.entities) std::ranges::fill(entity.materials, white_paint());
    return scene;
}

Result<SceneRadiance> fitted_radiance(const PointShading& shading, std::span<const SampledMesh> meshes,
                                      SceneRadiance start, const Progress& progress) {
    std::vector<RadiantMesh> fitted;
    for (std::size_t i = 0; i < meshes.size(); ++i)
        fitted.push_back({*meshes[i].mesh, std::move(start[i]), {}});
    HF_TRY_DONE(fit_radiance(shading, fitted, progress));
    for (std::size_t i = 0; i < meshes.size(); ++i) start[i] = std::move(fitted[i].radiance);
    return start;
}

RaySettings ray_settings(const PassShading& bake) {
    return {bake.ray_samples, bake.shading.settings.bounces.most};
}

/// Computes radiance with the shading of the bake; by rays, without indirect light.
///
/// shading, meshes  of a scene that is a variation of the bake's.
Result<SceneRadiance> radiance_as(const PassShading& bake, const PointShading& shading,
                                  std::span<const SampledMesh> meshes, const Progress& progress) {
    if (bake.ray_samples > 0)
        return ray_scene_radiance(shading.scene, {bake.ray_samples}, progress, shading.sharing);
    if (bake.dense) return dense_scene_radiance(shading.scene, shading.settings, progress, shading.sharing);
    if (meshes.empty()) return scene_radiance(shading, progress);
    Result<SceneRadiance> radiance = vertex_radiance(shading, meshes, {}, progress);
    if (!radiance || !bake.fitted) return radiance;
    return fitted_radiance(shading, meshes, std::move(*radiance), progress);
}

/// Computes openness: the radiance of white paint under uniform light of radiance 1.
Result<SceneRadiance> openness(const PassShading& bake, const Progress& progress) {
    const auto& [own, geometry, own_light, settings, visibility, indirect, sharing] = bake.shading;
    ShadedScene scene = in_white_paint(own);
    scene.lamps.clear();
    scene.environment = LatLongImage{4, 2, std::vector<Rgb>(8, Rgb(1.0f))};
    const SceneLight light = scene_light(scene.environment, settings, progress.stop);
    Result<SceneRadiance> open = radiance_as(
        bake, {scene, geometry, light, settings, visibility, nullptr, sharing}, bake.meshes, progress);
    if (!open) return open;
    for (std::vector<Outgoing>& values : *open)
        for (Outgoing& value : values)
            for (int c = 0; c < 3; ++c) value.diffuse[c] = std::min(value.diffuse[c], 1.0f);
    return open;
}

/// Copies lamps for a scene with a single instance.
void take_shapes(const std::vector<Lamp>& lamps, std::size_t instance, std::vector<Lamp>& alone) {
    alone = lamps;
    for (Lamp& lamp : alone) {
        if (lamp.looks_like == instance)
            lamp.looks_like = 0;
        else
            lamp.looks_like.reset();
    }
}

/// Computes the radiance of each instance alone.
Result<SceneRadiance> radiance_only(const PassShading& bake, const Progress& progress) {
    const ShadedScene& scene = bake.shading.scene;
    RenderSettings settings = bake.shading.settings;
    settings.occlusion = Occlusion::fields;  // There are no other instances.
    SceneRadiance result(scene.instances.size());
    ShadedScene alone{{}, {}, scene.environment, scene.eye};
    SceneLight light = bake.shading.light;
    for (std::size_t e = 0; e < scene.entities.size(); ++e) {
        alone.entities = {scene.entities[e]};
        std::optional<ShadingGeometry> geometry;  // Most of it depends on the entity only and is reused.
        for (std::size_t i = 0; i < scene.instances.size(); ++i) {
            if (scene.instances[i].entity != e) continue;
            alone.instances = {{0, scene.instances[i].placement}};
            if (!geometry) {
                HF_TRY(geometry, shading_geometry(alone, settings, progress));
            } else if (const Result<Done> placed = place_instances(alone, *geometry, progress); !placed) {
                return placed.error();
            }
            take_shapes(scene.lamps, i, alone.lamps);
            light.lamps = placed_lamps(alone.lamps);
            const auto mesh =
                bake.meshes.empty() ? std::span<const SampledMesh>() : bake.meshes.subspan(i, 1);
            Result<SceneRadiance> radiance =
                radiance_as(bake, {alone, *geometry, light, settings, nullptr, nullptr, bake.shading.sharing},
                            mesh, progress);
            if (!radiance) return radiance;
            result[i] = std::move(radiance->front());
        }
    }
    return result;
}

/// Computes the radiance by indirect light, black if the bake has none.
Result<SceneRadiance> radiance_by_bounces(const PassShading& bake,
                                          std::span<const std::span<const Outgoing>> full,
                                          const Progress& progress) {
    if (const RaySettings by_rays = ray_settings(bake); by_rays.samples > 0 && by_rays.bounces > 0)
        return ray_indirect_radiance(bake.shading.scene, bake.shading.scene.entities, by_rays, progress,
                                     bake.shading.sharing);
    if (!bake.shading.indirect || bake.meshes.empty()) {
        SceneRadiance black;
        for (const std::span<const Outgoing> values : full) black.emplace_back(values.size());
        if (!bake.shading.indirect) return black;
        HF_TRY_DONE(add_indirect_radiance(bake.shading, black, progress));
        return black;
    }
    const PointRadiance indirect_alone = [&](std::span<const InstancePoint> points) {
        return indirect_radiance(bake.shading, points, progress);
    };
    return vertex_values(bake.shading.scene, bake.meshes, {}, indirect_alone);
}

/// Returns one component of the radiance, with zeros for the other one.
SceneRadiance component(std::span<const std::span<const Outgoing>> full, Rgb Outgoing::*which) {
    SceneRadiance result;
    for (const std::span<const Outgoing> values : full) {
        result.emplace_back(values.size());
        for (std::size_t v = 0; v < values.size(); ++v) result.back()[v].*which = values[v].*which;
    }
    return result;
}

/// Computes the irradiance: pi times the radiance of white paint.
Result<SceneRadiance> irradiance(const PassShading& bake, const Progress& progress) {
    const auto& [own, geometry, light, settings, visibility, indirect, sharing] = bake.shading;
    const ShadedScene scene = in_white_paint(own);
    Result<SceneRadiance> made = radiance_as(
        bake, {scene, geometry, light, settings, visibility, indirect, sharing}, bake.meshes, progress);
    if (!made) return made;
    if (const RaySettings by_rays = ray_settings(bake); by_rays.samples > 0 && by_rays.bounces > 0) {
        HF_TRY(const SceneRadiance bounced,
               ray_indirect_radiance(own, scene.entities, by_rays, progress, sharing));
        for (std::size_t i = 0; i < bounced.size(); ++i)
            for (std::size_t v = 0; v < bounced[i].size(); ++v) (*made)[i][v] += bounced[i][v];
    }
    for (std::vector<Outgoing>& values : *made)
        for (Outgoing& value : values) value.diffuse *= static_cast<float>(pi);
    return made;
}

Result<SceneRadiance> pass_of(const PassShading& bake, std::span<const std::span<const Outgoing>> full,
                              RenderPass pass, const Progress& progress) {
    switch (pass) {
        case RenderPass::diffuse: return component(full, &Outgoing::diffuse);
        case RenderPass::specular: return component(full, &Outgoing::specular);
        case RenderPass::irradiance: return irradiance(bake, progress);
        case RenderPass::occlusion: return openness(bake, progress);
        case RenderPass::own_shadow: return radiance_only(bake, progress);
        case RenderPass::indirect: break;
    }
    return radiance_by_bounces(bake, full, progress);
}

}  // namespace

Result<std::vector<SceneRadiance>> render_passes(const PassShading& bake,
                                                 std::span<const std::span<const Outgoing>> full,
                                                 std::span<const RenderPass> passes,
                                                 const Progress& progress) {
    assert(full.size() == bake.shading.scene.instances.size());
    assert(bake.meshes.empty() || bake.meshes.size() == full.size());
    assert(!bake.fitted || !bake.meshes.empty());
    assert((!bake.dense && bake.ray_samples == 0) || bake.meshes.empty());
    std::vector<SceneRadiance> result;
    for (const RenderPass pass : passes) {
        HF_TRY(SceneRadiance made, pass_of(bake, full, pass, progress));
        result.push_back(std::move(made));
    }
    return result;
}

}  // namespace haarfield
