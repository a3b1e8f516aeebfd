#include "bridge/files/mesh_file.h"
#include "bridge/pictures/preview.h"
#include "bridge/povray/placed_bake.h"
#include "bridge/povray_import/scene_queries.h"
#include "scenes/bake_search.h"
#include "scenes/original_vertices.h"
#include "scenes/scene_bake.h"
#include "scenes/scene_shading.h"
#include "tools/error_report.h"
#include "tools/farm/task_share.h"
#include "tools/number_option.h"
#include "tools/scene_options.h"
#include "tools/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

struct BakeCommandOptions {
    SceneOptions scene;
    RenderChoices render;
    std::string output;
    std::vector<std::string> formats{"ply"};
    bool no_render = false;
    bool worst = false;
};

/// Calls write_baked_scene and warns about clamped radiance.
Result<BakedFiles> written_scene(const std::filesystem::path& folder, const std::string& name,
                                 const Camera& camera, const std::vector<BakedInstance>& instances,
                                 const BackgroundDescription& background, CommandContext& context) {
    Result<BakedFiles> files = write_baked_scene(folder, name, camera, instances, background);
    if (files && files->clamped_vertices > 0)
        context.warn(fmt::format("{}: the radiance of {} vertices is clamped to [0, 65000]", name,
                                 files->clamped_vertices));
    return files;
}

/// Calls original_bake. Warns about vertices without light and reports settings without effect.
OriginalBake at_original_vertices(const Scene& scene, const SceneEntities& entities,
                                  const std::vector<BakedInstance>& instances, bool with_images,
                                  CommandContext& context) {
    for (std::size_t i = 0; i < instances.size(); ++i) {
        const Entity& entity = scene.entities[scene.instances[i].entity];
        if (instances[i].mesh->positions.size() >= entity.fine_vertices) continue;
        context.message(fmt::format(
            "fine_vertices of entity {} has no effect: --original-vertices bakes the vertices of {}",
            entity.name, entity.mesh.string()));
        break;  // one message suffices
    }
    OriginalBake original = original_bake(entities, instances, with_images);
    if (original.unvalued > 0)
        context.warn(
            fmt::format("{} of the files' {} vertices belong to no triangle with an area and get radiance 0",
                        original.unvalued, original.vertices));
    context.report["original_vertices"] = {{"vertices", original.vertices}, {"unvalued", original.unvalued}};
    return original;
}

/// Prints and reports the error that a search reached, and its choices.
void report_search(const Scene& scene, const SearchOutcome& search, CommandContext& context) {
    const BakeError& error = search.error;
    const WorstPoint& worst = error.worst;
    const std::string& instance = scene.instances[worst.point.at.instance].name;
    auto& report = context.report["error"];
    report = error_report(error);
    report.update({{"target", search.target},
                   {"over", search.is_everywhere ? "surfaces" : "pixels"},
                   {"points", error.points},
                   {"references", error.references},
                   {"is_met", search.end == SearchEnd::reached},
                   {"reason", reason_of(search.end, search.vertex_budget)},
                   {"worst", {{"instance", instance}, {"error", worst.error}}},
                   {"choices",
                    {{"vertex_budget", search.vertex_budget},
                     {"colours", search.fitted ? "fitted" : "sampled"},
                     {"cut_edges", search.cut_edges},
                     {"directions", search.directions},
                     {"gathering_rays", search.gathering_rays},
                     {"bright_points", search.is_focused ? search.gathering_rays : 0},
                     {"face_size", search.face_size},
                     {"source_directions", search.source_directions},
                     {"light_coefficients", search.light_coefficients},
                     {"shaded_points", search.shaded_points},
                     {"rounds", search.rounds}}}});
    std::string place;
    if (!search.is_everywhere) {
        const int column = int(worst.point.pixel) % scene.camera.width,
                  row = int(worst.point.pixel) / scene.camera.width;
        report["worst"]["pixel"] = {column, row};
        place = fmt::format("pixel {}, {} of ", column, row);
    }
    context.print("{}\n", error_line(error));
    context.print("worst  {:.0f} % at {}{}\n", 100 * worst.error, place, instance);
    if (search.end != SearchEnd::reached)
        context.warn(fmt::format("the error is {:.3g} %; expected at most {:.2g} %: {}", 100 * error.total,
                                 100 * search.target, reason_of(search.end, search.vertex_budget)));
}

/// Draws the surroundings of the point with the largest error: a quarter of the picture's height.
Result<Done> write_worst(const std::filesystem::path& file, const Scene& scene, const ShadedScene& shaded,
                         const BakedScene& baked, const LatLongImage& background, CommandContext& context) {
    const MeshPoint& at = baked.search->error.worst.point.at;
    const ShadedInstance& instance = shaded.instances[at.instance];
    const Mesh& mesh = *shaded.entities[instance.entity].mesh;
    Vec3f place(0.0f);
    for (std::size_t c = 0; c < 3; ++c)
        place += mesh.positions[mesh.triangles[at.triangle][c]] * at.weights()[c];
    Camera camera = scene.camera;
    camera.target = instance.placement.point_to_world(place);
    camera.vertical_fov /= 4;
    camera.width = camera.height = 320;
    const Image picture = Preview().draw(camera, baked.instances, [&](const Vec3f& direction) {
        return radiance_from(background, Vec3d(direction));
    });
    HF_TRY_DONE(write_image(picture, file));
    context.report["error"]["worst"]["image"] = file.string();
    context.print("worst  {}\n", file.string());
    return Done{};
}

/// Writes the files that place the bake in an existing scene, and prints how to use them.
Result<PlacedBake> written_in_place(const std::filesystem::path& folder, const Scene& scene,
                                    const BakedFiles& files, CommandContext& context) {
    Result<PlacedBake> placed =
        write_placed_bake(folder, file_stem(scene), files, scene.camera, scene.surroundings);
    if (!placed) return placed;
    context.report["place"] = {{"include", placed->include.string()}, {"object", placed->object}};
    context.print("place  #include \"{}\" and object {{ {} }} place the bake in {}\n",
                  placed->include.filename().string(), placed->object,
                  scene.surroundings ? scene.surroundings->file.filename().string()
                                     : std::string("a scene of your own"));
    if (placed->scene.empty()) return placed;
    context.report["place"]["scene"] = placed->scene.string();
    return placed;
}

/// Renders the surroundings with the baked objects.
Result<Done> render_in_place(const std::filesystem::path& png, const PlacedBake& placed, const Scene& scene,
                             const SceneOptions& options, CommandContext& context) {
    constexpr double day = 86400;  // [s]
    QueryOptions povray;
    povray.threads = context.threads;
    povray.sandboxed = !context.unsandboxed;
    povray.seconds = day;
    povray.memory = std::uint64_t{1} << 38;
    std::vector<std::string> arguments{fmt::format("+W{}", scene.camera.width),
                                       fmt::format("+H{}", scene.camera.height)};
    if (options.antialiasing > 0)
        arguments.insert(arguments.end(), {"+A0.1", "+AM1", fmt::format("+R{}", options.antialiasing), "-J"});
    const Stopwatch watch;
    std::vector<std::filesystem::path> folders;
    for (const std::filesystem::path& file : {placed.scene, scene.surroundings->file})
        folders.push_back(std::filesystem::absolute(file).parent_path());
    if (!scene.surroundings->folder.empty()) folders.push_back(scene.surroundings->folder);
    HF_TRY_DONE(render_sandboxed(placed.scene, folders, png, std::move(arguments), povray, context.progress));
    context.report["place"]["image"] = png.string();
    context.print("image  {}: {} with the baked objects, rendered in {:.1f} s\n", png.string(),
                  scene.surroundings->file.filename().string(), watch.elapsed().wall);
    return Done{};
}

Result<ExitCode> run(const BakeCommandOptions& options, CommandContext& context) {
    RenderChoices render = options.render;
    render.bake.error = target_error(render);
    HF_TRY_DONE(check_bake(render.bake));
    const std::filesystem::path output = options.output;
    HF_TRY(Scene scene, opened_scene(options.scene));
    apply_bounces(scene, render.shading.bounces);
    HF_TRY(Environment environment, opened_environment(scene, context));
    if (render.bake.error) render.entities.fields = search_fields(scene, render.shading.occlusion);
    if (render.bake.evaluator == Evaluator::rays) render.entities.fields = FieldExtent::none;
    SceneEntities entities;
    ShadedScene shaded;
    std::optional<Stopwatch> watch;  // Without the first preparation.
    const BakeAttempt attempt = [&](std::optional<std::uint32_t> start,
                                    const BakeOptions& bake) -> Result<BakedScene> {
        HF_TRY(entities,
               opened_entities(start ? search_start(scene, *start) : scene, render, output, context));
        const bool is_first = !watch;
        if (is_first) {
            HF_TRY_DONE(place_camera(scene, entities, options.scene, context));
            expose_room(scene, entities, environment, context);
            shaded.environment = std::move(environment);
            watch.emplace();
        }
        shaded = shaded_scene(scene, entities, std::move(shaded.environment));
        std::vector<std::optional<MeshPoint>> pixels;
        if (bake.error && !bake.everywhere)
            pixels = Preview().points(scene.camera, preview_instances(entities, shaded));
        std::optional<PointSharing> sharing;
        // The tasks have shaded the vertices of the first start only.
        if (context.share && is_first) sharing = point_sharing(*context.share);
        return baked_scene(scene, entities, shaded, render.shading, bake, context.progress,
                           sharing ? &*sharing : nullptr, pixels);
    };
    HF_TRY(const BakedScene baked, repeated_bake(render.bake, attempt));
    if (context.share && !context.share->joins) return ExitCode::done;
    if (baked.search) report_search(scene, *baked.search, context);
    if (baked.refinement)
        context.report["refinement"] = {{"tolerance", *render.bake.refine},
                                        {"vertex_budget", baked.refinement->vertex_budget},
                                        {"largest_error", baked.refinement->largest_error},
                                        {"shaded_points", baked.refinement->shaded_points},
                                        {"rounds", baked.refinement->rounds}};
    if (baked.bounces)
        context.report["bounces"] = {{"computed", baked.bounces->computed},
                                     {"left_out", baked.bounces->left_out},
                                     {"matrix_bytes", baked.bounces->matrix_bytes}};
    const RunTime shading = watch->elapsed();

    const std::vector<BakedInstance>& instances = baked.instances;
    std::size_t vertices = 0;
    for (const BakedInstance& instance : instances) vertices += instance.radiance.size();
    context.report["vertices"] = vertices;
    report_time(context.report, "shade", shading);
    context.report["evaluator"] = render_option("evaluator").text(render);
    if (render.bake.evaluator == Evaluator::rays) context.report["samples"] = render.bake.samples;
    context.report["occlusion"] = render_option("occlusion").text(render);
    context.print("baked  {} vertices of {} instances in {:.2f} s\n", vertices, instances.size(),
                  shading.wall);

    if (context.progress.stop.stop_requested()) return interruption();
    const LatLongImage background = image_with_suns(std::move(shaded.environment));
    HF_TRY(const BakedFiles files,
           written_scene(output, file_stem(scene), scene.camera, instances,
                         BackgroundDescription{&background, false, scene.assumed_gamma}, context));
    if (options.worst && baked.search)
        HF_TRY_DONE(write_worst(output / "worst.png", scene, shaded, baked, background, context));
    context.report["scene"] = files.scene.string();
    for (const std::filesystem::path& image : files.images)
        context.report["images"].push_back(image.string());
    context.print("scene  {} with {} includes\n", files.scene.string(), files.includes.size());
    HF_TRY(const PlacedBake placed, written_in_place(output, scene, files, context));
    std::optional<OriginalBake> original;
    std::vector<MeshFormat> formats;
    for (const std::string& name : options.formats)
        formats.push_back(*std::ranges::find(mesh_formats(), name, &MeshFormat::name));
    if (render.entities.original_vertices)
        original = at_original_vertices(scene, entities, instances,
                                        std::ranges::any_of(formats, &MeshFormat::has_images), context);
    for (const MeshFormat& format : formats) {
        const std::filesystem::path mesh = output / (file_stem(scene) + "." + format.name);
        const std::vector<BakedInstance>& of_file = !original           ? instances
                                                    : format.has_images ? original->textured
                                                                        : original->instances;
        HF_TRY_DONE(format.write(mesh, of_file));
        context.report["meshes"].push_back(mesh.string());
        context.print("mesh   {}\n", mesh.string());
    }

    std::vector<std::filesystem::path> pass_scenes;
    for (const BakedPass& pass : baked.passes) {
        HF_TRY(const BakedFiles pass_files,
               written_scene(
                   output / pass.name, file_stem(scene) + "_" + pass.name, scene.camera, pass.instances,
                   {pass.has_environment ? &background : nullptr, false, scene.assumed_gamma}, context));
        pass_scenes.push_back(pass_files.scene);
        context.report["passes"].push_back({{"pass", pass.name}, {"scene", pass_files.scene.string()}});
        context.print("pass   {}\n", pass_files.scene.string());
    }

    if (options.no_render) return ExitCode::done;
    const std::filesystem::path exr = output / "baked.exr";
    const PovrayOptions povray = povray_options(scene, options.scene, context);
    HF_TRY(const RenderedScene rendered, render_scene(files.scene, exr, povray, context.progress));
    report_picture(exr, rendered.image, {&rendered.run, 1}, context);
    if (scene.surroundings)
        HF_TRY_DONE(render_in_place(output / "in_place.png", placed, scene, options.scene, context));
    for (std::size_t i = 0; i < pass_scenes.size(); ++i) {
        const std::filesystem::path picture = output / (baked.passes[i].name + ".exr");
        HF_TRY(const RenderedScene pass, render_scene(pass_scenes[i], picture, povray, context.progress));
        for (const std::string& warning : pass.run.warnings) context.warn("POV-Ray: " + warning);
        context.report["passes"][i]["image"] = picture.string();
        context.print("image  {} (and .png), traced in {:.1f} s\n", picture.string(), pass.run.trace_seconds);
    }
    return ExitCode::done;
}

}  // namespace

Command bake_command(CLI::App& program) {
    CLI::App* app =
        program.add_subcommand("bake", "Bake light into vertex colours, for POV-Ray and mesh files");
    const auto options = std::make_shared<BakeCommandOptions>();
    add_scene_option(*app, options->scene);
    app->add_option("-o,--output", options->output,
                    "Folder for NAME.pov, its includes, the mesh and the picture")
        ->required()
        ->type_name("DIR");
    add_picture_options(*app, options->scene);
    add_render_options(
        *app, options->render,
        {OptionSet::vertices, OptionSet::occlusion, OptionSet::lighting, OptionSet::depth, OptionSet::bake});
    app->get_option("--refine")->excludes(app->get_option("--original-vertices"));
    add_field_options(*app, options->render);
    std::vector<std::string> formats;
    std::string details;
    for (const MeshFormat& format : mesh_formats()) {
        formats.emplace_back(format.name);
        details += fmt::format("{}`{}`: {}.", details.empty() ? "" : " ", format.name, format.summary);
    }
    app->add_option("--format", options->formats, "Formats of the mesh, separated by commas\n" + details)
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember(formats))
        ->default_str("ply")
        ->type_name("FORMAT")
        ->group(files_group);
    app->add_flag("--worst", options->worst, "With --error: draw the place with the largest error, worst.png")
        ->group(shown_group);
    app->add_flag("--no-render", options->no_render, "Do not run POV-Ray")->group(speed_group);
    app->footer(
        "Example:\n  haarfield bake scenes/single_chair.toml -o out/chair\n"
        "ends with out/chair/baked.png, and out/chair/single_chair_Chair.inc for a scene of your own.");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
