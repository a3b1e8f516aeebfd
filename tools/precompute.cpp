#include "tools/command.h"
#include "tools/scene_options.h"

#include <CLI/CLI.hpp>

namespace haarfield {

namespace {

struct PrecomputeOptions {
    SceneOptions scene;
    RenderChoices render;
    std::string output = ".";
};

Result<ExitCode> run(const PrecomputeOptions& options, CommandContext& context) {
    HF_TRY(const Scene scene, opened_scene(options.scene));
    HF_TRY_DONE(opened_entities(scene, options.render, options.output, context));
    return ExitCode::done;
}

}  // namespace

Command precompute_command(CLI::App& program) {
    CLI::App* app =
        program.add_subcommand("precompute", "Compute or reuse the visibility field of each entity");
    const auto options = std::make_shared<PrecomputeOptions>();
    add_scene_option(*app, options->scene);
    app->add_option("-o,--output", options->output, "Folder of a later bake (default: the current folder)")
        ->type_name("DIR");
    add_render_options(*app, options->render, {OptionSet::vertices});
    add_field_options(*app, options->render);
    app->footer(
        "A field is reused if its mesh and settings are unchanged. Outdated or damaged fields are\n"
        "recomputed.\n"
        "Example:\n"
        "  haarfield precompute scenes/table_and_chairs.toml --fields out/fields");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
