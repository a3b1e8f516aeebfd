#include "scenes/scene_bake.h"

#include "fields/base/names.h"
#include "scenes/bake_search.h"
#include "shading/bake/bounced_radiance.h"
#include "shading/bake/colour_fit.h"
#include "shading/bake/dense_renderer.h"
#include "shading/bake/ray_renderer.h"
#include "shading/bake/render_passes.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace haarfield {
namespace {

const std::map<std::string, RenderPass> render_pass_of{
    {"diffuse", RenderPass::diffuse},       {"specular", RenderPass::specular},
    {"irradiance", RenderPass::irradiance}, {"occlusion", RenderPass::occlusion},
    {"own-shadow", RenderPass::own_shadow}, {"indirect", RenderPass::indirect}};

/// Shades the vertices of fine meshes, except by rays.
///
/// indirect  receives the scene's indirect light, if there are bounces.
Result<Done> shade_fine(const PointShading& direct, const BakeOptions& options,
                        std::optional<IndirectLight>& indirect, const Progress& progress, BakedScene& baked) {
    if (options.evaluator == Evaluator::tree) {
        HF_TRY(baked.fine, bounced_radiance(direct, indirect, progress));
        return Done{};
    }
    HF_TRY(baked.fine, dense_scene_radiance(direct.scene, direct.settings, progress, direct.sharing));
    if (direct.settings.bounces.most == 0) return Done{};
    HF_TRY(indirect, scene_indirect_light(direct, progress));
    PointShading lit = direct;
    lit.indirect = &*indirect;
    return add_indirect_radiance(lit, baked.fine, progress);
}

/// Shades meshes that are refined or fitted to the radiance.
///
/// shading  includes the indirect light, if there is any.
Result<Done> shade(const PointShading& shading, const SceneEntities& entities, const BakeOptions& options,
                   const Progress& progress, BakedScene& baked) {
    if (options.refine) {
        const std::size_t budget =
            options.vertex_budget ? *options.vertex_budget : usual_vertex_budget(entities);
        const std::vector<Mesh> start = surface_meshes(entities, budget / refinement_share);
        HF_TRY(std::vector<RadiantMesh> begun, mesh_radiance(shading, start, progress));
        HF_TRY(Refinement refined,
               refined_radiance(shading, {*options.refine, budget}, std::move(begun), progress));
        baked.refinement =
            RefinementOutcome{budget, refined.largest_error, refined.shaded_points, refined.rounds};
        baked.refined = std::move(refined.meshes);
    } else {
        HF_TRY(baked.refined, mesh_radiance(shading, fine_meshes(entities), progress));
    }
    if (options.colours == BakedColours::fitted) return fit_radiance(shading, baked.refined, progress);
    return Done{};
}

/// True if a search must use the size of cubemaps of the fields.
bool has_fields(const SceneEntities& entities) {
    return std::ranges::any_of(entities.entities,
                               [](const auto& entity) { return entity->field.has_surroundings(); });
}

/// Bakes to a target error.
///
/// indirect  receives the scene's indirect light, if there are bounces.
Result<Done> search(const PointShading& direct, const Scene& scene, const SceneEntities& entities,
                    const BakeOptions& options, int usual_face_size,
                    std::span<const std::optional<MeshPoint>> pixels, std::optional<IndirectLight>& indirect,
                    const Progress& progress, BakedScene& baked) {
    const std::size_t budget =
        options.vertex_budget ? *options.vertex_budget : search_budget(scene, entities);
    std::vector<DisplayedPoint> points;
    if (!options.everywhere) points = displayed_points(entities, direct.scene, pixels);
    const bool is_everywhere = points.empty();
    if (is_everywhere) points = displayed_area(entities, direct.scene);
    const int most_face_size =
        has_fields(entities) ? usual_face_size : std::max(usual_face_size, options.most_face_size);
    const ErrorTarget target{.error = *options.error,
                             .vertex_budget = budget,
                             .by_view = !is_everywhere,
                             .usual_face_size = usual_face_size,
                             .most_face_size = most_face_size,
                             .stops_early = options.stops_early};
    HF_TRY(TargetBake found, target_bake(direct, target, std::move(points), progress));
    baked.search = SearchOutcome{.target = *options.error,
                                 .error = found.error,
                                 .end = found.end,
                                 .vertex_budget = budget,
                                 .fitted = found.fitted,
                                 .cut_edges = found.cut_edges,
                                 .directions = found.directions,
                                 .gathering_rays = found.gathering_rays,
                                 .is_focused = found.indirect && found.indirect->lit,
                                 .face_size = found.face_size,
                                 .source_directions = found.source_directions,
                                 .light_coefficients = found.light_coefficients,
                                 .shaded_points = found.shaded_points,
                                 .rounds = found.rounds,
                                 .is_everywhere = is_everywhere,
                                 .is_stopped = found.is_stopped};
    baked.refined = std::move(found.meshes);
    indirect = std::move(found.indirect);
    return Done{};
}

/// The shaded meshes before their radiance is separated from textures.
struct ShadedMeshes {
    std::vector<SampledMesh> meshes;                  ///< By instance.
    std::vector<std::span<const Outgoing>> radiance;  ///< Radiance of the meshes' vertices.
};

ShadedMeshes shaded_meshes(const SceneEntities& entities, const BakedScene& baked) {
    ShadedMeshes shaded;
    for (std::size_t i = 0; i < entities.entity_of_instance.size(); ++i) {
        if (!baked.refined.empty()) {
            const RadiantMesh& refined = baked.refined[i];
            shaded.meshes.push_back({&refined.mesh, &refined.samples});
            shaded.radiance.emplace_back(refined.radiance);
        } else {
            const SceneEntity& entity = entities.of_instance(i);
            shaded.meshes.push_back({&entity.mesh.fine, &entity.occlusion->samples()});
            shaded.radiance.emplace_back(baked.fine[i]);
        }
    }
    return shaded;
}

/// Returns the instances for display, with their radiance separated from textures.
///
/// layered  becomes the radiance by instance; the instances refer to it.
std::vector<BakedInstance> layered_instances(const Scene& scene, const SceneEntities& entities,
                                             const ShadedMeshes& shaded,
                                             std::vector<LayeredRadiance>& layered) {
    std::vector<BakedInstance> instances;
    layered.resize(shaded.meshes.size());
    for (std::size_t i = 0; i < shaded.meshes.size(); ++i)
        instances.push_back(baked_instance(scene.instances[i], entities.of_instance(i),
                                           *shaded.meshes[i].mesh, shaded.radiance[i], layered[i]));
    return instances;
}

/// Returns the instances with values instead of radiance, and without images or cut-outs.
std::vector<BakedInstance> valued_instances(const std::vector<BakedInstance>& instances,
                                            const std::vector<LayeredRadiance>& values) {
    std::vector<BakedInstance> valued;
    for (std::size_t i = 0; i < instances.size(); ++i)
        valued.push_back({instances[i].name, instances[i].mesh, instances[i].placement, values[i].textured});
    return valued;
}

/// Returns a pass for writing, made from its computed values.
///
/// shaded  the shaded meshes of the full picture.
BakedPass baked_pass(const std::string& name, const SceneRadiance& values, const Scene& scene,
                     const SceneEntities& entities, ShadedMeshes shaded,
                     const std::vector<BakedInstance>& instances) {
    const RenderPass pass = render_pass_of.at(name);
    BakedPass made{name, {}, {}, {}};
    if (pass == RenderPass::own_shadow) {
        shaded.radiance.assign(values.begin(), values.end());
        made.instances = layered_instances(scene, entities, shaded, made.layered);
        made.has_environment = true;
        for (const BakedInstance& instance : made.instances) {
            std::vector<Rgb>& layered = made.values.emplace_back();
            for (std::size_t v = 0; v < instance.radiance.size(); ++v)
                layered.push_back(displayed_radiance(instance, v));
        }
        for (BakedInstance& instance : made.instances) instance.shows_reflection = false;
        return made;
    }
    made.values = total(values);
    for (std::size_t i = 0; i < instances.size(); ++i) {
        const SceneEntity& entity = entities.of_instance(i);
        std::vector<Rgb>& here = made.values[i];
        if (pass == RenderPass::diffuse)
            here = layered_radiance(*instances[i].mesh, entity.surfaces, values[i]).textured;
        if (pass == RenderPass::specular)
            here = tinted_specular_light(*instances[i].mesh, entity.surfaces, here);
        made.layered.push_back({here, {}});
        // A picture of irradiance shows a white diffuse surface.
        if (pass == RenderPass::irradiance)
            for (Rgb& value : made.layered.back().textured) value *= static_cast<float>(1 / pi);
    }
    made.instances = valued_instances(instances, made.layered);
    for (BakedInstance& instance : made.instances) instance.shows_reflection = false;
    return made;
}

/// Adds the passes, and their values to the instances.
Result<Done> add_passes(const Scene& scene, const SceneEntities& entities, const PointShading& shading,
                        const BakeOptions& options, const ShadedMeshes& shaded, const Progress& progress,
                        BakedScene& baked) {
    std::vector<RenderPass> wanted;
    for (const std::string& name : options.passes) wanted.push_back(render_pass_of.at(name));
    const bool is_refined = !baked.refined.empty();
    const PassShading bake{
        shading, is_refined ? std::span<const SampledMesh>(shaded.meshes) : std::span<const SampledMesh>(),
        options.colours == BakedColours::fitted, options.evaluator == Evaluator::dense,
        options.evaluator == Evaluator::rays ? options.samples : 0};
    HF_TRY(std::vector<SceneRadiance> values, render_passes(bake, shaded.radiance, wanted, progress));
    if (is_partial(shading.sharing)) return Done{};
    for (std::size_t p = 0; p < options.passes.size(); ++p)
        baked.passes.push_back(
            baked_pass(options.passes[p], values[p], scene, entities, shaded, baked.instances));
    for (const BakedPass& pass : baked.passes) {
        std::string name = pass.name;
        std::ranges::replace(name, '-', '_');
        const bool is_scalar = render_pass_of.at(pass.name) == RenderPass::occlusion;
        for (std::size_t i = 0; i < baked.instances.size(); ++i)
            baked.instances[i].passes.push_back({name, pass.values[i], is_scalar});
    }
    return Done{};
}

}  // namespace

std::size_t usual_vertex_budget(const SceneEntities& entities) {
    std::size_t own = 0;
    for (std::size_t i = 0; i < entities.entity_of_instance.size(); ++i)
        own += visible_surface(entities.of_instance(i).mesh).positions.size();
    return std::max(RefinementSettings().vertex_budget, own + own / 2);
}

std::vector<std::string> pass_names() {
    std::vector<std::string> names;
    for (const auto& [name, pass] : render_pass_of) names.push_back(name);
    return names;
}

Result<Done> check_bake(const BakeOptions& options) {
    if (options.samples < 1) return Error{"samples", "is 0; expected at least 1"};
    if (options.error &&
        (options.refine || options.colours == BakedColours::fitted || options.evaluator != Evaluator::tree))
        return Error{"error " + fmt::format("{}", *options.error),
                     "chooses vertices and colours; expected neither refine, colours fitted nor another "
                     "evaluator"};
    if (options.everywhere && !options.error)
        return Error{"everywhere", "says where an error is measured; expected an error"};
    if (options.evaluator != Evaluator::tree && (options.refine || options.colours == BakedColours::fitted))
        return Error{options.evaluator == Evaluator::dense ? "evaluator dense" : "evaluator rays",
                     "knows vertices only; expected neither refine nor colours fitted"};
    for (auto pass = options.passes.begin(); pass != options.passes.end(); ++pass) {
        if (!render_pass_of.contains(*pass))
            return Error{"pass " + *pass, "is unknown; expected one of: " + quoted_list(pass_names())};
        if (std::find(options.passes.begin(), pass, *pass) != pass)
            return Error{"pass " + *pass, "is listed twice"};
    }
    return Done{};
}

Result<BakedScene> baked_scene(const Scene& scene, const SceneEntities& entities, const ShadedScene& shaded,
                               const RenderSettings& settings, const BakeOptions& options,
                               const Progress& progress, const PointSharing* sharing,
                               std::span<const std::optional<MeshPoint>> pixels) {
    BakedScene baked;
    const bool by_rays = options.evaluator == Evaluator::rays;
    if (by_rays) {
        HF_TRY(baked.fine,
               ray_scene_radiance(shaded, {options.samples, settings.bounces.most}, progress, sharing));
        if (options.passes.empty()) {  // nothing else is needed
            if (!is_partial(sharing))
                baked.instances =
                    layered_instances(scene, entities, shaded_meshes(entities, baked), baked.layered);
            return baked;
        }
    }
    RenderSettings chosen = settings;
    if (options.error && !has_fields(entities)) chosen.face_size = std::min(settings.face_size, 16);
    HF_TRY(ShadingGeometry geometry, shading_geometry(shaded, chosen, progress));
    SceneLight light = scene_light(shaded, chosen, progress.stop);
    PointShading shading{shaded, geometry, light, chosen, nullptr, nullptr, sharing};
    std::optional<IndirectLight> indirect;
    const bool is_fine = !options.error && !options.refine && options.colours == BakedColours::sampled;
    if (options.error) {
        HF_TRY_DONE(
            search(shading, scene, entities, options, settings.face_size, pixels, indirect, progress, baked));
        if (baked.search->is_stopped || is_partial(sharing)) return baked;
        shading.sharing = nullptr;  // a search has all points
        if (!options.passes.empty()) {
            chosen.sources.direction_factor = baked.search->source_directions;
            chosen.light_coefficients = baked.search->light_coefficients;
            const int face_size = std::max(settings.face_size, baked.search->face_size);
            if (chosen.face_size < face_size) {
                chosen.face_size = face_size;
                HF_TRY(geometry, shading_geometry(shaded, chosen, progress));
            }
            light = scene_light(shaded, chosen, progress.stop);
        }
    } else if (is_fine && !by_rays) {
        HF_TRY_DONE(shade_fine(shading, options, indirect, progress, baked));
        if (settings.bounces.most > 0 && is_partial(sharing)) return baked;
    } else if (!by_rays && settings.bounces.most > 0) {
        HF_TRY(indirect, scene_indirect_light(shading, progress));
    }
    if (indirect) {
        shading.indirect = &*indirect;
        shading.sharing = nullptr;  // a process with indirect light has all points
        baked.bounces = BounceOutcome{indirect->bounces, indirect->left_out, indirect->transport_bytes};
    }
    if (!is_fine && !options.error) HF_TRY_DONE(shade(shading, entities, options, progress, baked));
    const ShadedMeshes shaded_instances = shaded_meshes(entities, baked);
    if (!is_partial(shading.sharing))
        baked.instances = layered_instances(scene, entities, shaded_instances, baked.layered);
    HF_TRY_DONE(add_passes(scene, entities, shading, options, shaded_instances, progress, baked));
    return baked;
}

}  // namespace haarfield
