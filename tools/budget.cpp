#include "bridge/pictures/budget_report.h"
#include "bridge/pictures/preview.h"
#include "bridge/povray/reference_scene.h"
#include "fields/file/write_file.h"
#include "scenes/camera_frame.h"
#include "scenes/scene_budget.h"
#include "scenes/scene_shading.h"
#include "tools/command.h"
#include "tools/number_option.h"
#include "tools/scene_options.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

struct BudgetOptions {
    SceneOptions scene;
    RenderChoices render;
    std::string output;
    std::size_t points = 400;
    std::uint32_t samples = 4096;
    std::optional<int> lights;  // of POV-Ray's dome; set if the oracle is to be validated
};

constexpr int checked_width = 160;  // width of POV-Ray's picture [pixels]
constexpr int checked_face_size = 256;

/// Returns the positions of the worst vertices in the picture. Vertices that are not visible are skipped.
std::vector<BudgetReport::Mark> worst_marks(const ShadedScene& scene, const Camera& camera,
                                            const std::vector<std::optional<MeshPoint>>& pixels,
                                            const std::vector<BudgetVertex>& vertices) {
    constexpr std::size_t most = 20;
    const CameraFrame frame = camera_frame(camera);
    const double half_height = std::tan(0.5 * double(camera.vertical_fov));
    double mean = 0;
    for (const BudgetVertex& vertex : vertices)
        mean += double(luminance(vertex.exact)) / double(vertices.size());
    std::vector<BudgetReport::Mark> marks;
    for (const BudgetVertex& vertex : vertices) {
        if (marks.size() == most) break;
        const ShadedInstance& instance = scene.instances[vertex.instance];
        const Mesh& mesh = *scene.entities[instance.entity].mesh;
        const auto placed = [&](std::uint32_t v) {
            return Vec3d(instance.placement.point_to_world(mesh.positions[v]));
        };
        const Vec3d place = placed(vertex.vertex), from_eye = place - Vec3d(camera.position);
        const double depth = from_eye.dot(frame.forward);
        if (depth <= 0) continue;
        const double scale = camera.height / (2 * half_height * depth),
                     x = camera.width * 0.5 + from_eye.dot(frame.right) * scale,
                     y = camera.height * 0.5 - from_eye.dot(frame.up) * scale;
        if (!(x >= 0 && x < camera.width && y >= 0 && y < camera.height)) continue;
        const std::optional<MeshPoint>& seen =
            pixels[std::size_t(y) * std::size_t(camera.width) + std::size_t(x)];
        if (!seen || seen->instance != vertex.instance) continue;
        const auto& corners = mesh.triangles[seen->triangle];
        if ((placed(corners[0]) - place).length() > 0.02 * depth) continue;  // on another side of the object
        marks.push_back({x, y, double((vertex.baked - vertex.exact).length()) / std::sqrt(3.0) / mean});
    }
    return marks;
}

/// Compares the dense oracle with POV-Ray, both with the original meshes.
Result<OracleCheck> checked_oracle(const BudgetOptions& options, const Scene& scene,
                                   const Environment& environment, CommandContext& context) {
    HF_TRY(const SceneEntities originals, opened_originals(scene, context));
    Camera camera = scene.camera;
    camera.width = std::min(camera.width, checked_width);
    camera.height = std::max(1, scene.camera.height * camera.width / scene.camera.width);
    std::vector<ReferenceInstance> instances = reference_instances(scene, originals);
    for (ReferenceInstance& instance : instances) instance.surfaces = {};  // compare light alone
    HF_TRY(const ReferenceFiles files,
           write_reference_scene(options.output, file_stem(scene) + "_check", camera, instances, environment,
                                 *options.lights, {}, lamps_of(scene.lamps), scene.filters,
                                 scene.assumed_gamma));
    for (const std::string& warning : files.warnings) context.warn(warning);
    PovrayOptions povray = povray_options(scene, options.scene, context);
    povray.width = camera.width;
    povray.height = camera.height;
    povray.antialiasing = 0;
    HF_TRY(const ReferencePicture picture, rendered_reference(files, povray, context.progress));
    return oracle_check(shaded_scene(scene, originals, environment), camera, picture, checked_face_size,
                        options.points, context.progress);
}

void report_entries(const std::vector<BudgetEntry>& entries, CommandContext& context) {
    context.print("{:<20} {:>10} {:>9} {:>9} {:>7}\n", "approximation", "rel. RMSE", "99 %", "bias",
                  "points");
    context.report["budget"] = nlohmann::json::array();
    for (const BudgetEntry& entry : entries) {
        context.print("{:<20} {:>8.3f} % {:>7.2f} % {:>+7.3f} % {:>7}  {}\n", entry.name,
                      100 * entry.relative_rmse, 100 * entry.relative_99, 100 * entry.bias, entry.points,
                      entry.meaning);
        context.report["budget"].push_back({{"approximation", entry.name},
                                            {"meaning", entry.meaning},
                                            {"relative_rmse", entry.relative_rmse},
                                            {"relative_99", entry.relative_99},
                                            {"bias", entry.bias},
                                            {"noise", entry.noise},
                                            {"without_noise", entry.without_noise()},
                                            {"points", entry.points}});
    }
}

void report_check(const OracleCheck& check, CommandContext& context) {
    context.print(
        "oracle  agrees with POV-Ray at {} of {} points ({:.1f} %): relative RMSE {:.4f}, bias {:+.4f}; "
        "POV-Ray's own error {:.4f}\n",
        check.agreeing, check.points,
        100.0 * double(check.agreeing) / double(std::max<std::size_t>(1, check.points)), check.relative_rmse,
        check.bias, check.reference_error);
    context.report["oracle"] = {{"points", check.points},
                                {"agreeing", check.agreeing},
                                {"relative_rmse", check.relative_rmse},
                                {"bias", check.bias},
                                {"reference_relative_error", check.reference_error}};
}

/// Reports the vertices with errors above 20 %, and prints the worst of them.
void report_wrong_vertices(const Scene& scene, const SceneBudget& budget, CommandContext& context) {
    constexpr std::size_t most_named = 10;
    auto& list = context.report["wrong_vertices"];
    list = nlohmann::json::array();
    std::size_t named = 0;
    for (const BudgetVertex& vertex : budget.wrong) {
        const std::string& name = scene.instances[vertex.instance].name;
        const double baked = double(luminance(vertex.baked)), exact = double(luminance(vertex.exact));
        list.push_back({{"instance", name}, {"vertex", vertex.vertex}, {"baked", baked}, {"exact", exact}});
        if (++named <= most_named)
            context.print("wrong  vertex {} of {}: found {:.4g}; expected {:.4g}\n", vertex.vertex, name,
                          baked, exact);
    }
    context.print("wrong  {} of {} vertices have an error above 20 %\n", budget.wrong.size(),
                  budget.vertices.size());
}

Result<ExitCode> run(const BudgetOptions& options, CommandContext& context) {
    const std::filesystem::path output = options.output;
    HF_TRY(Scene scene, opened_scene(options.scene));
    // The folder is made before minutes of work, even if the fields are stored elsewhere.
    HF_TRY_DONE(make_folder(output));
    HF_TRY(Environment environment, opened_environment(scene, context));
    HF_TRY(const SceneEntities entities, opened_entities(scene, options.render, output, context));
    HF_TRY_DONE(place_camera(scene, entities, options.scene, context));
    expose_room(scene, entities, environment, context);
    const ShadedScene shaded = shaded_scene(scene, entities, environment);
    RenderSettings settings = options.render.shading;
    apply_bounces(scene, settings.bounces);
    Preview preview;
    const auto pixels = preview.points(scene.camera, preview_instances(shaded));
    HF_TRY(SceneBudget budget, scene_budget(entities, shaded, settings, options.points, pixels,
                                            context.progress, options.samples));
    report_entries(budget.entries, context);
    context.report["vertices"] = budget.vertices.size();
    report_wrong_vertices(scene, budget, context);

    const LatLongImage background = image_with_suns(environment);
    const Image picture =
        preview.draw(scene.camera, preview_instances(shaded, budget.radiance),
                     [&](const Vec3f& direction) { return radiance_from(background, Vec3d(direction)); });
    BudgetReport page;
    page.title = scene.name;
    page.entries = budget.entries;
    page.vertices = budget.vertices.size();
    page.preview = &picture;
    page.worst = worst_marks(shaded, scene.camera, pixels, budget.vertices);
    page.commands = {context.command_line};
    if (options.lights) {
        HF_TRY(const OracleCheck check, checked_oracle(options, scene, environment, context));
        report_check(check, context);
        page.oracle = check;
    }
    HF_TRY_DONE(write_budget_report(page, output / "budget.html"));
    context.print("report  {}\n", (output / "budget.html").string());
    return ExitCode::done;
}

}  // namespace

Command budget_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand(
        "budget", "Measure the error of a bake and attribute it to each approximation");
    const auto options = std::make_shared<BudgetOptions>();
    add_scene_option(*app, options->scene);
    app->add_option("-o,--output", options->output, "Folder for budget.html and the fields")
        ->required()
        ->type_name("DIR");
    add_view_options(*app, options->scene);
    add_render_options(*app, options->render, {OptionSet::occlusion, OptionSet::lighting, OptionSet::depth});
    add_field_options(*app, options->render);
    add_number(*app, "--points", options->points, "Random vertices, and pixels, at which errors are measured",
               {1, 1e6})
        ->capture_default_str()
        ->type_name("N");
    add_number(*app, "--samples", options->samples,
               "Sampled directions per vertex for the comparison with rays, which use no fields", {8, 1e8})
        ->capture_default_str()
        ->type_name("N");
    add_number(*app, "--lights", options->lights,
               "Also validate the oracle with POV-Ray's ray tracer and a dome of N lights", {16, 100000})
        ->type_name("N");
    app->footer(
        "Each approximation is measured alone, relative to dense sums over exact visibility.\n"
        "Example:\n  haarfield budget scenes/single_chair.toml -o out/chair --lights 1024");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
