#include "bridge/povray_import/imported_scene.h"
#include "bridge/povray_import/models_in_scene.h"
#include "fields/base/names.h"
#include "fields/file/input_file.h"
#include "fields/file/write_file.h"
#include "fields/model/model_file.h"
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
    std::string object;
    int detail = 48;
    double object_seconds = 20;
    std::string povray = "povray";
    std::string into;
    std::vector<double> at;
};

Result<Done> check_new(const std::filesystem::path& file, bool overwrite) {
    std::error_code ignored;
    if (!overwrite && std::filesystem::exists(file, ignored))
        return Error{file.string(), "exists already; choose another folder, or use --overwrite"};
    return Done{};
}

/// Returns true if POV-Ray must evaluate a file: it is a scene in POV-Ray's language, but not one of meshes
/// in plain data.
Result<bool> needs_povray(const std::filesystem::path& file, const std::string& object) {
    if (!object.empty()) return true;
    if (lower_ending(file) != ".pov") return false;
    HF_TRY(const WrappedScene scene, wrapped_scene(file));
    // Objects that are placed are searched for among the meshes of the file.
    const bool has_solids = std::ranges::any_of(scene.statements, [](const SceneStatement& statement) {
        return statement.keyword != "mesh2" && statement.keyword != "object" &&
               statement.keyword != "union" && statement.keyword != "merge" &&
               statement.keyword != "light_source";
    });
    return has_solids || !ModelFile::open(file);
}

/// Reports a scene that has been imported, and writes its file.
///
/// notes  further lines of comment at the top of the file; or empty.
Result<ExitCode> write_scene(const Scene& scene, const std::filesystem::path& file, CommandContext& context,
                             const std::string& notes = {}) {
    const std::filesystem::path output = file.parent_path();
    const std::string text = scene_text(scene, output,
                                        fmt::format("{}\nhaarfield bake {} -o {}{}", context.command_line,
                                                    file.string(), output.string(), notes));
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

/// Imports a scene that POV-Ray evaluates.
Result<ExitCode> run_povray_import(const ImportOptions& options, CommandContext& context) {
    if (options.files.size() > 1)
        return Error{options.files[1], "a POV-Ray scene is imported alone; expected one file"};
    const std::filesystem::path source = options.files[0], output = options.output;
    Scene named;
    named.name = options.object.empty() ? source.stem().string() : options.object;
    const std::string name = file_stem(named);
    const std::filesystem::path file = output / (name + ".toml");
    HF_TRY_DONE(check_new(file, options.overwrite));
    PovrayImport wanted;
    wanted.queries.program = options.povray;
    wanted.queries.wrap.object = options.object;
    wanted.queries.sandboxed = !context.unsandboxed;
    wanted.detail = options.detail;
    wanted.object_seconds = options.object_seconds;
    if (options.up == "z") wanted.z_up = true;
    wanted.unit = double(options.unit);
    if (options.size) wanted.size = double(*options.size);
    wanted.with_environment = options.environment.empty();
    wanted.vertices = options.wanted.vertices;
    HF_TRY(ImportedPovrayScene imported,
           imported_povray_scene(source, output, name, wanted, context.progress));
    for (const std::string& warning : imported.warnings) context.warn(warning);
    Scene& scene = imported.scene;
    scene.name = named.name;
    if (!options.environment.empty() && options.environment != no_environment) {
        HF_TRY_DONE(check_input_file(options.environment, "a lat-long image"));
        scene.environment.image = options.environment;
        scene.environment.exposure.reset();
    } else if (scene.lamps.empty() && !scene.emits() && scene.environment.is_black()) {
        // A declared object contains no light.
        scene.environment.sky = AnalyticSky();
        scene.environment.exposure.reset();
    }
    context.report["objects"] = imported.objects;
    context.report["surfaces"] = imported.surfaces;
    context.report["distant"] = imported.distant;
    context.report["transparent"] = imported.transparent;
    context.report["failed"] = imported.failed;
    context.print("objects  {}: {} meshes, {} in the environment, {} transparent, {} without a surface\n",
                  imported.objects, imported.surfaces, imported.distant, imported.transparent,
                  imported.failed);
    return write_scene(scene, file, context);
}

/// Imports models into an existing POV-Ray scene.
Result<ExitCode> run_into_scene(const ImportOptions& options, CommandContext& context) {
    constexpr double hour = 3600;  // [s] The light is rendered with the scene's radiosity and area lights.
    const std::filesystem::path output = options.output;
    PlaceInScene place;
    place.file = options.into;
    place.at = {options.at[0], options.at[1], options.at[2]};
    place.queries.program = options.povray;
    place.queries.sandboxed = !context.unsandboxed;
    place.queries.seconds = hour;
    place.models = options.wanted;
    place.models.z_up = options.up == "z";
    place.models.unit = double(options.unit);
    if (options.size) place.models.size = double(*options.size);
    const std::vector<std::filesystem::path> files(options.files.begin(), options.files.end());
    Scene named;
    named.name = files.front().stem().string();
    const std::filesystem::path file = output / (file_stem(named) + ".toml"),
                                light = output / (file_stem(named) + "_light.exr");
    HF_TRY_DONE(check_new(file, options.overwrite));
    HF_TRY_DONE(check_new(light, options.overwrite));
    HF_TRY(ModelsInScene models, models_in_scene(files, place, light, context.progress));
    for (const std::string& warning : models.warnings) context.warn(warning);
    models.scene.name = named.name;
    const std::string at =
        fmt::format("{:.6g},{:.6g},{:.6g}", models.probe.x, models.probe.y, models.probe.z);
    const std::string difference =
        fmt::format("{:.1f} % RMS, {:.1f} % at the worst corner", 100 * models.corner_difference,
                    100 * models.largest_corner_difference);
    context.report["probe"] = {{"at", {models.probe.x, models.probe.y, models.probe.z}},
                               {"light", light.string()},
                               {"lights", models.lights},
                               {"corner_difference", models.corner_difference},
                               {"largest_corner_difference", models.largest_corner_difference}};
    context.print("light  {}: at {} of {}, {} lights\n", light.string(), at, options.into, models.lights);
    context.print("error  irradiance at the corners of the models' box differs by {}\n", difference);
    return write_scene(
        models.scene, file, context,
        fmt::format(
            "\n\nThe environment is the light of {} at {}, the centre of the models' box.\n"
            "Objects and lights nearby count as distant. At the corners of the box, irradiance differs "
            "by {}.",
            std::filesystem::path(options.into).filename().string(), at, difference));
}

Result<ExitCode> run(const ImportOptions& options, CommandContext& context) {
    if (!options.into.empty()) return run_into_scene(options, context);
    const std::filesystem::path output = options.output;
    HF_TRY(const bool whole, needs_povray(options.files[0], options.object));
    if (whole) return run_povray_import(options, context);
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
    return write_scene(scene, file, context);
}

}  // namespace

Command import_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("import", "Write a scene file for models, ready to bake");
    const auto options = std::make_shared<ImportOptions>();
    app->add_option("FILE", options->files,
                    "Models: OBJ, PLY, glTF (.gltf, .glb), STL, OFF, POV-Ray's mesh2 (.inc, .pov);\nor one "
                    "POV-Ray scene (.pov)")
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
    app->add_option("--object", options->object,
                    "Import one object that a POV-Ray file declares, instead of a scene")
        ->type_name("NAME");
    add_number(*app, "--detail", options->detail,
               "POV-Ray scenes: cells along an object that fills the picture", {8, 512})
        ->capture_default_str()
        ->type_name("N");
    add_number(*app, "--object-seconds", options->object_seconds,
               "POV-Ray scenes: limit of processor time for sampling one object", {0.1, 1e5})
        ->capture_default_str()
        ->type_name("S");
    app->add_option("--povray", options->povray, "POV-Ray's program")
        ->capture_default_str()
        ->type_name("FILE");
    CLI::Option* into =
        app->add_option("--into", options->into,
                        "POV-Ray scene in which the models shall stand, and which lights them")
            ->type_name("FILE");
    CLI::Option* at = add_number(*app, "--at", options->at,
                                 "Where they stand: the middle of their bottom, in that scene", {-1e6, 1e6})
                          ->delimiter(',')
                          ->expected(3)
                          ->allow_extra_args(false)
                          ->type_name("X,Y,Z");
    into->needs(at)->excludes("--environment")->excludes("--floor")->excludes("--object");
    at->needs(into);
    app->add_flag("--overwrite", options->overwrite, "Replace an existing scene");
    app->footer(
        "The scene refers to the model files and uses their materials and images. The camera and the\n"
        "exposure are found automatically; edit them as you like. Overlapping models of several files are\n"
        "placed side by side. Models of POV-Ray files are mirrored, because POV-Ray is left-handed,\n"
        "unless the file's camera has a negative `right`. In a room whose faces point inwards, the camera\n"
        "is placed inside.\n"
        "POV-Ray evaluates scenes with other objects than meshes, in a sandbox. Their objects become "
        "meshes.\n"
        "Example:\n"
        "  haarfield import scenes/meshes/chair.obj -o out/import --floor\n"
        "  haarfield bake out/import/chair.toml -o out/import");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
