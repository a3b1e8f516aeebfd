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
    HF_TRY(const FieldVerdict verdict,
           verify_field(options.field, options.allow_unsealed ? Unsealed::allowed : Unsealed::refused));
    context.print("{}: good\n", options.field);
    if (!verdict.sealed) context.print("not sealed: saved by another program; its checksums are valid\n");
    if (!verdict.grids_compared)
        context.print(
            "its grids for viewers were written by another OpenVDB version and were not compared\n");
    return ExitCode::done;
}

}  // namespace

Command verify_command(CLI::App& program) {
    CLI::App* app =
        program.add_subcommand("verify", "Verify all checksums and handles of a visibility field");
    const auto options = std::make_shared<VerifyOptions>();
    app->add_option("FIELD", options->field, "The field (.vdb)")->required()->type_name("");
    add_unsealed_option(*app, options->allow_unsealed);
    app->footer(
        "If anything is wrong, prints the reason and exits with code 1.\n"
        "Example:\n  haarfield verify out/chair/fields/chair.vdb");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
