#include "fields/file/input_file.h"
#include "fields/file/write_file.h"
#include "scenes/scene_import.h"
#include "scenes/scene_writer.h"
#include "tools/command.h"
#include "tools/number_option.h"
#include "tools/scene_options.h"

#include <fmt/format.h>

namespace haarfield {

namespace {

constexpr std::string_view no_environment = "none";

struct ImportOptions {
    std::vector<std::string> files;
    std::string output;
    std::string environment;
    std::string up = "y";
    float unit = 1;
    std::optional<float> size;
    SceneImport wanted;
    bool overwrite = false;
};

Result<Done> check_new(const std::filesystem::path& file, bool overwrite) {
    std::error_code ignored;
    if (!overwrite && std::filesystem::exists(file, ignored))
        return Error{file.string(), "exists already; choose another folder, or use --overwrite"};
    return Done{};
}

Result<ExitCode> run(const ImportOptions& options, CommandContext& context) {
    const std::filesystem::path output = options.output;
    SceneImport wanted = options.wanted;
    wanted.z_up = options.up == "z";
    wanted.unit = double(options.unit);
    if (options.size) wanted.size = double(*options.size);
    const std::vector<std::filesystem::path> files(options.files.begin(), options.files.end());
    wanted.no_environment = options.environment == no_environment;
    if (!options.environment.empty() && !wanted.no_environment) {
        HF_TRY_DONE(check_input_file(options.environment, "a lat-long image"));
        wanted.environment = options.environment;
    }
    HF_TRY(ImportedScene imported, scene_of_models(files, output, wanted, context.progress));
    for (const std::string& warning : imported.warnings) context.warn(warning);
    Scene& scene = imported.scene;
    scene.name = files.front().stem().string();
    const std::filesystem::path file = output / (file_stem(scene) + ".toml"), floor = output / "floor.obj";
    HF_TRY_DONE(check_new(file, options.overwrite));
    HF_TRY_DONE(make_folder(output));
    if (!imported.floor_obj.empty()) {
        HF_TRY_DONE(check_new(floor, options.overwrite));
        HF_TRY_DONE(write_file(floor, imported.floor_obj));
    }
    const std::string text = scene_text(
        scene, output,
        fmt::format("{}\nhaarfield bake {} -o {}", context.command_line, file.string(), output.string()));
    HF_TRY_DONE(write_file(file, text));
    context.report["scene"] = file.string();
    context.report["entities"] = scene.entities.size();
    context.report["instances"] = scene.instances.size();
    context.report["camera_found"] = !scene.finds_camera;
    context.report["lights"] = scene.lamps.size();
    context.print("scene  {}: {} entities, {} instances{}\n", file.string(), scene.entities.size(),
                  scene.instances.size(),
                  scene.lamps.empty() ? "" : fmt::format(", {} lights", scene.lamps.size()));
    return ExitCode::done;
}

}  // namespace

Command import_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("import", "Write a scene file for models, ready to bake");
    const auto options = std::make_shared<ImportOptions>();
    app->add_option("FILE", options->files,
                    "Models: OBJ, PLY, glTF (.gltf, .glb), STL, OFF, POV-Ray's mesh2 (.inc, .pov)")
        ->required()
        ->type_name("");
    app->add_option("-o,--output", options->output,
                    "Folder for the scene, which is named after the first model")
        ->required()
        ->type_name("DIR");
    app->add_option("--environment", options->environment,
                    "Lat-long image that replaces the clear sky; none: only the lights of the files")
        ->type_name("FILE");
    app->add_flag(
        "--floor", options->wanted.floor,
        "Add a floor below the models that reaches the horizon and is as bright as the environment there");
    app->add_flag("--keep-places", options->wanted.keep_places,
                  "Keep the positions of models from several files, even if they overlap");
    app->add_flag("--whole", options->wanted.whole, "Make one entity per file, regardless of its parts");
    app->add_option("--up", options->up, "The models' upward axis")
        ->check(CLI::IsMember({"y", "z"}))
        ->capture_default_str();
    CLI::Option* unit =
        add_number(*app, "--unit", options->unit, "Length of the models' unit, in metres", {1e-6, 1e6})
            ->capture_default_str()
            ->type_name("M");
    add_number(*app, "--scale-to", options->size,
               "Scale the models so that their longest side has this length, in metres", {1e-3, 1e5})
        ->excludes(unit)
        ->type_name("M");
    add_number(*app, "--vertices", options->wanted.vertices,
               "Approximate number of baked vertices of all objects together", {1000, 20e6})
        ->capture_default_str()
        ->type_name("N");
    app->add_flag("--overwrite", options->overwrite, "Replace an existing scene");
    app->footer(
        "The scene refers to the model files and uses their materials and images. The camera and the\n"
        "exposure are found automatically; edit them as you like. Overlapping models of several files are\n"
        "placed side by side. Models of POV-Ray files are mirrored, because POV-Ray is left-handed,\n"
        "unless the file's camera has a negative `right`. In a room whose faces point inwards, the camera\n"
        "is placed inside.\n"
        "Example:\n"
        "  haarfield import scenes/meshes/chair.obj -o out/import --floor\n"
        "  haarfield bake out/import/chair.toml -o out/import");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
