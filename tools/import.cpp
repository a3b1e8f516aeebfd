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
        return Error{file.string(), "is there already; wanted another folder, or --overwrite"};
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
        if (const Result<Done> good = check_input_file(options.environment, "a lat-long image"); !good)
            return good.error();
        wanted.environment = options.environment;
    }
    Result<ImportedScene> imported = scene_of_models(files, output, wanted, context.progress);
    if (!imported) return imported.error();
    for (const std::string& warning : imported->warnings) context.warn(warning);
    Scene& scene = imported->scene;
    scene.name = files.front().stem().string();
    const std::filesystem::path file = output / (file_stem(scene) + ".toml"), floor = output / "floor.obj";
    if (const Result<Done> good = check_new(file, options.overwrite); !good) return good.error();
    if (const Result<Done> made = make_folder(output); !made) return made.error();
    if (!imported->floor_obj.empty()) {
        if (const Result<Done> good = check_new(floor, options.overwrite); !good) return good.error();
        if (const Result<Done> written = write_file(floor, imported->floor_obj); !written)
            return written.error();
    }
    const std::string text = scene_text(scene, output,
                                        fmt::format("{}\nhaarfield bake {} -o {} --refine 0.01",
                                                    context.command_line, file.string(), output.string()));
    if (const Result<Done> written = write_file(file, text); !written) return written.error();
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
    CLI::App* app = program.add_subcommand("import", "Write a scene that shows models, ready to be baked");
    const auto options = std::make_shared<ImportOptions>();
    app->add_option("FILE", options->files,
                    "Models: OBJ, PLY, glTF (.gltf, .glb), STL, OFF, POV-Ray's mesh2 (.inc, .pov)")
        ->required()
        ->type_name("");
    app->add_option("-o,--output", options->output, "Folder for the scene, named as the first model")
        ->required()
        ->type_name("DIR");
    app->add_option(
           "--environment", options->environment,
           "Light from this lat-long image instead of a clear sky; none: only the lights of the files")
        ->type_name("FILE");
    app->add_flag(
        "--floor", options->wanted.floor,
        "Put a floor below the models that reaches to the horizon, as bright as the environment there");
    app->add_flag("--keep-places", options->wanted.keep_places,
                  "Leave models of several files where their files place them, though they overlap");
    app->add_flag("--whole", options->wanted.whole, "One entity for each file, whatever its parts are");
    app->add_option("--up", options->up, "The models' axis that points upwards")
        ->check(CLI::IsMember({"y", "z"}))
        ->capture_default_str();
    CLI::Option* unit =
        add_number(*app, "--unit", options->unit, "What a unit of the models is, in metres", {1e-6, 1e6})
            ->capture_default_str()
            ->type_name("M");
    add_number(*app, "--scale-to", options->size,
               "Scale the models so that their longest side is this, in metres", {1e-3, 1e5})
        ->excludes(unit)
        ->type_name("M");
    add_number(*app, "--vertices", options->wanted.vertices, "To be baked, of all objects together, about",
               {1000, 20e6})
        ->capture_default_str()
        ->type_name("N");
    app->add_flag("--overwrite", options->overwrite, "Replace a scene that is there");
    app->footer(
        "The scene refers to the models where they are, takes their materials and images, and finds its\n"
        "camera and exposure; edit it as you like. Models of several files that overlap are placed side by\n"
        "side. Models of POV-Ray files are mirrored, because POV-Ray is left-handed, unless the file's\n"
        "camera has a negative `right`. A room whose faces point inwards is recognized: the camera then\n"
        "stands inside it.\n"
        "Example:\n  haarfield import scenes/meshes/chair.obj -o out/import --floor\n"
        "  haarfield bake out/import/chair.toml -o out/import");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
