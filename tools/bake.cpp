#include "bridge/baked_scene.h"
#include "bridge/glb_file.h"
#include "bridge/mesh_file.h"
#include "shading/bake/colour_fit.h"
#include "shading/bake/dense_renderer.h"
#include "shading/bake/mesh_refinement.h"
#include "shading/scene/lighting.h"
#include "tools/command.h"
#include "tools/number_option.h"
#include "tools/scene_options.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

struct BakeOptions {
    SceneOptions scene;
    FieldOptions fields;
    OcclusionOptions occlusion;
    RenderSettings settings;
    std::string output;
    std::string evaluator = "tree";
    std::optional<float> refine;
    std::size_t vertex_budget = RefinementSettings().vertex_budget;
    std::string colours = "sampled";
    std::vector<std::string> formats{"ply"};
    bool no_render = false;
};

/// The scene's instances as they are written, with what they refer to.
struct BakedScene {
    std::vector<RadiantMesh> refined;  ///< By instance; empty if the entities' fine meshes serve.
    SceneRadiance fine;                ///< Of the fine meshes, by instance; or empty.
    std::vector<SeenRadiance> seen;    ///< By instance; empty where surfaces are plain.
    std::vector<BakedInstance> instances;
};

/// Of the vertices of fine meshes, or of meshes that suit the radiance.
Result<Done> shade(const PointShading& shading, const SceneEntities& entities, const BakeOptions& options,
                   CommandContext& context, BakedScene& baked) {
    if (!options.refine && options.colours == "sampled") {
        Result<SceneRadiance> radiance = scene_radiance(shading, context.progress);
        if (!radiance) return radiance.error();
        baked.fine = std::move(*radiance);
        return Done{};
    }
    if (options.refine) {
        const std::vector<Mesh> start = surface_meshes(entities, options.vertex_budget / refinement_share);
        Result<std::vector<RadiantMesh>> begun = mesh_radiance(shading, start, context.progress);
        if (!begun) return begun.error();
        Result<Refinement> refined = refined_radiance(shading, {*options.refine, options.vertex_budget},
                                                      std::move(*begun), context.progress);
        if (!refined) return refined.error();
        context.report["refinement"] = {{"tolerance", *options.refine},
                                        {"vertex_budget", options.vertex_budget},
                                        {"largest_error", refined->largest_error},
                                        {"shaded_points", refined->shaded_points},
                                        {"rounds", refined->rounds}};
        baked.refined = std::move(refined->meshes);
    } else {
        Result<std::vector<RadiantMesh>> fine =
            mesh_radiance(shading, fine_meshes(entities), context.progress);
        if (!fine) return fine.error();
        baked.refined = std::move(*fine);
    }
    if (options.colours == "fitted") return fit_radiance(shading, baked.refined, context.progress);
    return Done{};
}

/// The instances, whose radiance is parted where there are textures.
Result<Done> add_instances(const Scene& scene, const SceneEntities& entities, const PointShading& shading,
                           const Progress& progress, BakedScene& baked) {
    std::vector<const Mesh*> meshes;
    std::vector<std::span<const Rgb>> radiance;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const SceneEntity& entity = *entities.entities[entities.entity_of_instance[i]];
        const bool is_refined = !baked.refined.empty();
        meshes.push_back(is_refined ? &baked.refined[i].mesh : &entity.mesh.fine);
        radiance.emplace_back(is_refined ? baked.refined[i].radiance : baked.fine[i]);
    }
    SceneRadiance highlights(meshes.size());
    if (parts_highlights(entities)) {
        Result<SceneRadiance> found =
            highlight_radiance(shading, meshes, radiance, parted_materials(entities), progress);
        if (!found) return found.error();
        highlights = std::move(*found);
    }
    baked.seen.resize(meshes.size());
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        const SceneEntity& entity = *entities.entities[entities.entity_of_instance[i]];
        const Instance& instance = scene.instances[i];
        BakedInstance& added = baked.instances.emplace_back(
            BakedInstance{instance.name, meshes[i], instance.placement, radiance[i]});
        if (std::ranges::all_of(entity.surfaces, &Surface::is_plain)) continue;
        baked.seen[i] = seen_radiance(*meshes[i], entity.surfaces, radiance[i], highlights[i]);
        added.radiance = baked.seen[i].under;
        added.over = baked.seen[i].over;
        added.surfaces = entity.surfaces;
    }
    return Done{};
}

Result<BakedScene> baked_scene(const Scene& scene, const SceneEntities& entities, const ShadedScene& shaded,
                               const RenderSettings& settings, const BakeOptions& options,
                               CommandContext& context) {
    const Result<ShadingGeometry> geometry = shading_geometry(shaded, settings, context.progress);
    if (!geometry) return geometry.error();
    const SceneLight light = scene_light(shaded.environment, settings, context.progress.stop);
    const PointShading shading{shaded, *geometry, light, settings};
    BakedScene baked;
    if (options.evaluator == "dense") {
        Result<SceneRadiance> radiance = dense_scene_radiance(shaded, settings, context.progress);
        if (!radiance) return radiance.error();
        baked.fine = std::move(*radiance);
    } else if (const Result<Done> done = shade(shading, entities, options, context, baked); !done) {
        return done.error();
    }
    if (const Result<Done> added = add_instances(scene, entities, shading, context.progress, baked); !added)
        return added.error();
    return baked;
}

Result<ExitCode> run(const BakeOptions& options, CommandContext& context) {
    if (options.evaluator == "dense" && (options.refine || options.colours == "fitted"))
        return Error{"--evaluator dense",
                     "knows vertices only; wanted neither --refine nor --colours fitted"};
    const std::filesystem::path output = options.output;
    Result<Scene> scene = opened_scene(options.scene);
    if (!scene) return scene.error();
    Result<Environment> environment = opened_environment(*scene, context);
    if (!environment) return environment.error();
    const Result<SceneEntities> entities = opened_entities(*scene, options.fields, output, context);
    if (!entities) return entities.error();
    if (const Result<Done> placed = place_camera(*scene, *entities, options.scene, context); !placed)
        return placed.error();

    const ShadedScene shaded = shaded_scene(*scene, *entities, std::move(*environment));
    RenderSettings settings = options.settings;
    settings.face_size = options.fields.face_size;
    apply_occlusion(options.occlusion, settings);
    const auto start = std::chrono::steady_clock::now();
    const Result<BakedScene> baked = baked_scene(*scene, *entities, shaded, settings, options, context);
    if (!baked) return baked.error();
    const double shade_seconds = seconds_since(start);

    const std::vector<BakedInstance>& instances = baked->instances;
    std::size_t vertices = 0;
    for (const BakedInstance& instance : instances) vertices += instance.radiance.size();
    context.report["vertices"] = vertices;
    context.report["shade_seconds"] = shade_seconds;
    context.report["evaluator"] = options.evaluator;
    context.report["occlusion"] = options.occlusion.choice;
    context.print("baked  {} vertices of {} instances in {:.2f} s\n", vertices, instances.size(),
                  shade_seconds);

    if (context.progress.stop.stop_requested()) return Error{"", interrupted};
    const LatLongImage background = image_with_suns(shaded.environment);
    const Result<BakedFiles> files = write_baked_scene(output, file_stem(*scene), scene->camera, instances,
                                                       BackgroundDescription{&background});
    if (!files) return files.error();
    if (files->clamped_vertices > 0)
        context.warn(
            fmt::format("the radiance of {} vertices is clamped to [0, 65000]", files->clamped_vertices));
    context.report["scene"] = files->scene.string();
    for (const std::filesystem::path& image : files->images)
        context.report["images"].push_back(image.string());
    context.print("scene  {} with {} includes\n", files->scene.string(), files->includes.size());
    for (const std::string& format : options.formats) {
        const std::filesystem::path mesh = output / (file_stem(*scene) + "." + format);
        const auto write = format == "glb"   ? write_baked_glb
                           : format == "csv" ? write_baked_csv
                                             : write_baked_ply;
        if (const Result<Done> written = write(mesh, instances); !written) return written.error();
        context.report["meshes"].push_back(mesh.string());
        context.print("mesh   {}\n", mesh.string());
    }

    if (options.no_render) return ExitCode::done;
    const std::filesystem::path exr = output / "baked.exr";
    const Result<RenderedScene> rendered =
        render_scene(files->scene, exr, povray_options(*scene, options.scene, context), context.progress);
    if (!rendered) return rendered.error();
    report_picture(exr, rendered->image, {&rendered->run, 1}, context);
    return ExitCode::done;
}

}  // namespace

Command bake_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("bake", "Shade every vertex and write it for POV-Ray");
    const auto options = std::make_shared<BakeOptions>();
    add_scene_option(*app, options->scene);
    app->add_option("-o,--output", options->output,
                    "Folder for NAME.pov, its includes, the mesh and the picture")
        ->required()
        ->type_name("DIR");
    add_field_options(*app, options->fields);
    add_occlusion_options(*app, options->occlusion);
    add_picture_options(*app, options->scene);
    app->add_flag("--no-render", options->no_render, "Do not run POV-Ray");
    add_shading_options(*app, options->settings);
    app->add_option("--evaluator", options->evaluator,
                    "tree: wavelet product integrals; dense: plain sums, slow")
        ->check(CLI::IsMember({"tree", "dense"}))
        ->capture_default_str();
    add_number(*app, "--refine", options->refine,
               "Split triangles where interpolated radiance is off by more than this, relative to it "
               "plus the mean radiance",
               {1e-4, 1})
        ->type_name("E");
    add_number(*app, "--vertex-budget", options->vertex_budget, "At most so many vertices with --refine",
               {1, 50e6})
        ->capture_default_str()
        ->type_name("N");
    app->add_option("--colours", options->colours,
                    "sampled: radiance at the vertices; fitted: what interpolates best between them, too")
        ->check(CLI::IsMember({"sampled", "fitted"}))
        ->capture_default_str();
    app->add_option(
           "--format", options->formats,
           "The mesh for other programs, separated by commas: ply; glb: glTF with linear radiance as "
           "COLOR_0; csv: a table")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"ply", "glb", "csv"}))
        ->default_str("ply")
        ->type_name("FORMAT");
    app->footer(
        "Example:\n  haarfield bake scenes/single_chair.toml -o out/chair\n"
        "ends with out/chair/baked.png, and out/chair/single_chair_Chair.inc for a scene of your own.");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
