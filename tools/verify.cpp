#include "fields/field/field_file.h"
#include "tools/command.h"
#include "tools/scene_options.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace haarfield {

namespace {

struct VerifyOptions {
    std::string field;
    bool allow_unsealed = false;
};

Result<ExitCode> run(const VerifyOptions& options, const CommandContext& context) {
    const Result<FieldVerdict> verdict =
        verify_field(options.field, options.allow_unsealed ? Unsealed::allowed : Unsealed::refused);
    if (!verdict) return verdict.error();
    context.print("{}: good\n", options.field);
    if (!verdict->sealed) context.print("not sealed: another program saved it; its own checksums hold\n");
    if (!verdict->grids_compared)
        context.print(
            "its grids for viewers were written by another OpenVDB, and not compared with the field\n");
    return ExitCode::done;
}

}  // namespace

Command verify_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("verify", "Check every checksum and handle of a visibility field");
    const auto options = std::make_shared<VerifyOptions>();
    app->add_option("FIELD", options->field, "The field (.vdb)")->required()->type_name("");
    add_unsealed_option(*app, options->allow_unsealed);
    app->footer(
        "Exit code 1, with the reason, if anything is off.\n"
        "Example:\n  haarfield verify out/chair/fields/chair.vdb");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
