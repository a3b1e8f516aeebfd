#include "bridge/povray/reference_lights.h"
#include "tools/command.h"
#include "tools/farm/task_share.h"
#include "tools/number_option.h"
#include "tools/scene_options.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

struct ReferenceOptions {
    SceneOptions scene;
    std::string output;
    int lights = 1024;
    double relative_error = 0;  // instead of `lights`, unless 0
    bool radiosity = false;     // instead of lights
    int bounces = 0;
};

/// Returns the number of lights for the required error.
Result<int> chosen_lights(const std::filesystem::path& folder, const std::string& stem, const Camera& camera,
                          std::span<const ReferenceInstance> instances, const Environment& environment,
                          std::span<const Lamp> lamps, const PovrayOptions& options, double wanted,
                          CommandContext& context) {
    HF_TRY(const LightEstimate estimate, lights_for_error(folder, stem, camera, instances, environment, lamps,
                                                          options, wanted, context.progress));
    context.print("lights {}, expected relative error {:.4f}\n", estimate.lights, estimate.relative_error);
    if (estimate.relative_error > wanted)
        context.warn(
            fmt::format("a relative error of {} needs more than {} lights", wanted, estimate.lights));
    return estimate.lights;
}

/// Renders the scene lit by POV-Ray's radiosity instead of a dome.
Result<ExitCode> render_by_radiosity(const ReferenceFiles& files, const std::filesystem::path& exr,
                                     std::span<const ReferenceInstance> instances,
                                     const PovrayOptions& povray, CommandContext& context) {
    for (const ReferenceInstance& instance : instances)
        if (std::ranges::any_of(instance.materials,
                                [](const Material& material) { return material.specular != Rgb(0.0f); }))
            context.warn(
                fmt::format("{} has specular light, which POV-Ray's radiosity omits", instance.name));
    HF_TRY(const RenderedScene picture, radiosity_picture(files.scene, povray, context.progress));
    HF_TRY_DONE(write_picture(exr, picture.image, files.scene, {&picture.run, 1}, povray, context));
    context.report["scene"] = files.scene.string();
    return ExitCode::done;
}

Result<ExitCode> run(const ReferenceOptions& options, CommandContext& context) {
    const std::filesystem::path output = options.output;
    HF_TRY(Scene scene, opened_scene(options.scene));
    HF_TRY(const TracedScene traced, opened_for_tracing(scene, options.scene, context));
    const std::vector<ReferenceInstance>& instances = traced.instances;
    if (context.progress.stop.stop_requested()) return interruption();
    const std::string stem = file_stem(scene) + "_reference";
    const PovrayOptions povray = povray_options(scene, options.scene, context);
    const std::vector<Lamp> lamps = lamps_of(scene.lamps);
    Result<int> lights = options.lights;
    if (options.relative_error > 0)
        lights = chosen_lights(output, stem, scene.camera, instances, traced.environment, lamps, povray,
                               options.relative_error, context);
    if (!lights) return lights.error();
    HF_TRY(const ReferenceFiles files,
           write_reference_scene(output, stem, scene.camera, instances, traced.environment, *lights,
                                 {options.bounces}, lamps, scene.filters, scene.assumed_gamma));
    for (const std::string& warning : files.warnings) context.warn(warning);
    const std::filesystem::path exr = output / "reference.exr";
    if (options.radiosity) return render_by_radiosity(files, exr, instances, povray, context);
    context.print("scene  {} with {} lights\n", files.scene.string(), files.lights + files.lamps);

    HF_TRY(const ReferencePicture picture,
           context.share ? shared_reference(files, povray, context.progress, *context.share)
                         : rendered_reference(files, povray, context.progress));
    if (context.share && !context.share->joins) return ExitCode::done;
    HF_TRY_DONE(write_picture(exr, picture.image, files.scene, picture.run, povray, context));
    const double error = double(*picture.image.relative_error);
    context.print("error  {:.4f}, the relative error of the reference itself\n", error);
    if (const std::string warning = reference_warning(error); !warning.empty()) context.warn(warning);
    context.report["lights"] = files.lights;
    context.report["bounces"] = options.bounces;
    context.report["scene"] = files.scene.string();
    context.report["relative_error"] = error;
    return ExitCode::done;
}

}  // namespace

Command reference_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("reference", "Render the scene with POV-Ray's own ray tracer");
    const auto options = std::make_shared<ReferenceOptions>();
    add_scene_option(*app, options->scene);
    app->add_option("-o,--output", options->output, "Folder for NAME_reference.pov and the picture")
        ->required()
        ->type_name("DIR");
    CLI::Option* lights =
        add_number(*app, "--lights", options->lights,
                   "Maximum number of distant lights that represent the environment", {16, 100000})
            ->capture_default_str()
            ->type_name("N");
    CLI::Option* relative_error =
        add_number(*app, "--relative-error", options->relative_error,
                   "Use as many lights as a relative error E of the reference requires", {1e-4, 1})
            ->excludes(lights)
            ->type_name("E");
    app->add_flag(
           "--radiosity", options->radiosity,
           "Use POV-Ray's radiosity instead of lights, as a check for smooth skies; without specular light")
        ->excludes(lights)
        ->excludes(relative_error);
    add_number(
        *app, "--bounces", options->bounces,
        "Number of bounces of indirect light between diffuse surfaces, by POV-Ray's radiosity. Takes minutes "
        "and adds noise that the error does not include. 0: direct light alone, like bake --bounces 0",
        {0, 20})
        ->capture_default_str()
        ->excludes("--radiosity")
        ->type_name("N");
    add_picture_options(*app, options->scene);
    app->footer(
        "Renders two independent sets of lights. The reference is their mean. Their difference gives the\n"
        "error of the reference, which `compare` also prints.\n"
        "Example:\n  haarfield reference scenes/single_chair.toml -o out/chair --relative-error 0.01");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
