#include "bridge/reference_scene.h"
#include "tools/command.h"
#include "tools/scene_options.h"

#include <fmt/format.h>

namespace haarfield {

namespace {

struct ReferenceOptions {
    SceneOptions scene;
    std::string output;
    int lights = LightDomeOptions().lights;
};

Result<ExitCode> run(const ReferenceOptions& options, Session& session) {
    const std::filesystem::path output = options.output;
    const Result<Scene> scene = opened_scene(options.scene);
    if (!scene) return scene.error();
    const Result<LatLongImage> environment = opened_environment(*scene, session);
    if (!environment) return environment.error();

    // The original meshes only: neither subdivided nor simplified.
    Scene plain = *scene;
    for (Entity& entity : plain.entities) {
        entity.fine_vertices = 0;
        entity.coarse_triangles = 0;
    }
    SceneEntityOptions wanted;
    wanted.fields = false;
    const Result<SceneEntities> entities = prepare_scene_entities(plain, wanted, session.progress);
    if (!entities) return entities.error();
    for (const std::string& warning : entities->warnings) session.warn(warning);

    std::vector<ReferenceInstance> instances;
    for (std::size_t i = 0; i < scene->instances.size(); ++i) {
        const Instance& instance = scene->instances[i];
        const SceneEntity& entity = *entities->entities[entities->entity_of_instance[i]];
        instances.push_back(
            {instance.name, &entity.mesh.original, entity.materials, instance.translate, instance.scale});
    }
    LightDomeOptions dome;
    dome.lights = options.lights;
    if (session.progress.stop.stop_requested()) return Error{"", interrupted};
    const std::string stem = file_stem(*scene) + "_reference";
    const Result<ReferenceFiles> files =
        write_reference_scene(output, stem, scene->camera, instances, *environment, dome);
    if (!files) return files.error();
    for (const std::string& warning : files->warnings) session.warn(warning);
    session.report["lights"] = files->lights;
    session.report["scene"] = files->scene.string();
    fmt::print("scene  {} with {} lights\n", files->scene.string(), files->lights);

    const Result<Done> rendered =
        rendered_picture(*scene, options.scene, files->scene, output / "reference.exr", session);
    if (!rendered) return rendered.error();
    return ExitCode::done;
}

}  // namespace

Command reference_command(CLI::App& program) {
    CLI::App* app =
        program.add_subcommand("reference", "Render the same scene with POV-Ray's own ray tracer");
    const auto options = std::make_shared<ReferenceOptions>();
    add_scene_option(*app, options->scene);
    app->add_option("-o,--output", options->output, "Folder for NAME_reference.pov and the picture")
        ->required()
        ->type_name("DIR");
    app->add_option("--lights", options->lights, "Distant lights that stand for the environment, at most")
        ->check(CLI::Range(8, 100000))
        ->capture_default_str()
        ->type_name("N");
    add_picture_options(*app, options->scene);
    app->footer("Example:\n  haarfield reference scenes/single_chair.toml -o out/chair --lights 256");
    return {app, [options](Session& session) { return run(*options, session); }};
}

}  // namespace haarfield
