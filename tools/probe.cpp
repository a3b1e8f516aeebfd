#include "bridge/povray_import/light_probe.h"
#include "fields/file/write_file.h"
#include "scenes/image.h"
#include "tools/command.h"
#include "tools/number_option.h"

#include <fmt/format.h>

namespace haarfield {

namespace {

struct ProbeOptions {
    std::string file;
    std::string output;
    std::vector<double> at;
    std::vector<std::string> without;
    int width = 1024;
    std::string povray = "povray";
};

Result<ExitCode> run(const ProbeOptions& options, CommandContext& context) {
    LightProbe probe;
    probe.place = {options.at[0], options.at[1], options.at[2]};
    probe.without = options.without;
    probe.width = 2 * (options.width / 2);
    probe.queries.program = options.povray;
    probe.queries.sandboxed = !context.unsandboxed;
    const std::filesystem::path output = options.output;
    if (output.has_parent_path()) HF_TRY_DONE(make_folder(output.parent_path()));
    HF_TRY(const ProbedLight probed, probed_light(options.file, probe, context.progress));
    HF_TRY_DONE(write_image(probed.light, output));
    context.report["light"] = output.string();
    context.report["lights"] = probed.lights;
    context.print("light  {}: {} x {}, {} lights\n", output.string(), probed.light.width, probed.light.height,
                  probed.lights);
    return ExitCode::done;
}

}  // namespace

Command probe_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("probe", "Render the light at a place in a POV-Ray scene");
    const auto options = std::make_shared<ProbeOptions>();
    app->add_option("SCENE", options->file, "POV-Ray scene (.pov)")->required()->type_name("");
    app->add_option("-o,--output", options->output, "Lat-long image (.exr)")->required()->type_name("FILE");
    add_number(*app, "--at", options->at, "The place, in the scene's coordinates", {-1e7, 1e7})
        ->required()
        ->delimiter(',')
        ->expected(3)
        ->allow_extra_args(false)
        ->type_name("X,Y,Z");
    app->add_option("--without", options->without,
                    "Leave out top-level objects with this name or keyword; may be repeated")
        ->type_name("NAME");
    add_number(*app, "--width", options->width, "Width of the image in pixels", {16, 16384})
        ->capture_default_str()
        ->type_name("N");
    app->add_option("--povray", options->povray, "POV-Ray's program")
        ->capture_default_str()
        ->type_name("FILE");
    app->footer(
        "The image is in haarfield's frame, right-handed with +y up: use it as the environment of a scene.\n"
        "Lights of the scene are discs with a radius of one degree. POV-Ray runs in a sandbox.\n"
        "Example:\n"
        "  haarfield probe desk.pov --at 0,1,0 --without Lamp -o light.exr");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
