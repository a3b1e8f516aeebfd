#include "bridge/pictures/image_difference.h"
#include "bridge/povray/reference_picture.h"
#include "bridge/povray/reference_scene.h"
#include "fields/base/names.h"
#include "fields/file/input_file.h"
#include "tools/command.h"
#include "tools/number_option.h"
#include "tools/scene_options.h"

#include <fmt/format.h>

namespace haarfield {

namespace {

struct ResidualOptions {
    SceneOptions scene;
    std::string output;
    int lights = 1024;
    double most_bias = 0.005, most_rms = 0.02;
};

/// Returns the includes that `bake` wrote for the scene's instances.
Result<ReferenceBounces> baked_objects(const Scene& scene, const std::filesystem::path& folder) {
    std::vector<std::string> names;
    for (const Instance& instance : scene.instances) names.push_back(instance.name);
    const std::string stem = file_stem(scene);
    ReferenceBounces bounces;
    for (const std::string& object : povray_object_names(stem, names)) {
        const std::filesystem::path include =
            folder / (stem + object.substr(povray_identifier(stem).size()) + ".inc");
        HF_TRY_DONE(check_input_file(include, "an include file that bake wrote"));
        bounces.baked.push_back({include, object});
    }
    return bounces;
}

Result<ExitCode> run(const ResidualOptions& options, CommandContext& context) {
    const std::filesystem::path output = options.output;
    HF_TRY(Scene scene, opened_scene(options.scene));
    HF_TRY(const ReferenceBounces bounces, baked_objects(scene, output));
    HF_TRY(const Image baked, read_image(output / "baked.exr"));
    HF_TRY(const TracedScene traced, opened_for_tracing(scene, options.scene, context));
    HF_TRY(const ReferenceFiles files,
           write_reference_scene(output, file_stem(scene) + "_residual", scene.camera, traced.instances,
                                 traced.environment, options.lights, bounces, lamps_of(scene.lamps),
                                 scene.filters, scene.assumed_gamma));
    for (const std::string& warning : files.warnings) context.warn(warning);
    PovrayOptions povray = povray_options(scene, options.scene, context);
    povray.width = baked.width;
    povray.height = baked.height;
    HF_TRY(const ReferencePicture picture, rendered_reference(files, povray, context.progress));
    HF_TRY_DONE(
        write_picture(output / "residual.exr", picture.image, files.scene, picture.run, povray, context));
    HF_TRY(const ImageDifference difference, image_difference(baked, picture.image));
    const double own = double(*picture.image.relative_error);
    context.report["bias"] = difference.bias;
    context.report["relative_rmse"] = difference.relative_rmse;
    context.report["relative_error"] = own;
    context.print("bias           {:+.4f}\nrelative rmse  {:.4f}\nlights         relative error {:.4f}\n",
                  difference.bias, difference.relative_rmse, own);
    if (std::abs(difference.bias) <= options.most_bias && difference.relative_rmse <= options.most_rms)
        return ExitCode::done;
    context.message(fmt::format(
        "the bake does not reproduce itself; expected a bias of at most {} and an RMSE of at most {}",
        options.most_bias, options.most_rms));
    return ExitCode::images_differ;
}

}  // namespace

Command residual_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand(
        "residual", "Check that a bake reproduces itself when POV-Ray gathers its light");
    const auto options = std::make_shared<ResidualOptions>();
    add_scene_option(*app, options->scene);
    app->add_option("-o,--output", options->output, "The folder of the bake, also for residual.exr")
        ->required()
        ->type_name("DIR");
    add_number(*app, "--lights", options->lights,
               "Maximum number of distant lights that represent the environment", {16, 100000})
        ->capture_default_str()
        ->type_name("N");
    add_number(*app, "--max-bias", options->most_bias,
               "Exit with code 3 if the bake is brighter or darker by more than this fraction", {0, 1})
        ->capture_default_str()
        ->type_name("E");
    add_number(*app, "--max-rmse", options->most_rms, "Exit with code 3 if the relative RMSE is larger",
               {0, 1})
        ->capture_default_str()
        ->type_name("E");
    add_picture_options(*app, options->scene);
    app->footer(
        "The radiance of a diffuse surface is the sum of direct light and of light from other surfaces.\n"
        "The ray tracer takes the former from lights and the latter from the baked meshes. The resulting\n"
        "picture must equal that of the bake, which must be in the same folder.\n"
        "Example:\n"
        "  haarfield residual scenes/gallery/room.toml -o out/room");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
