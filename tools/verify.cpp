#include "fields/field/field_file.h"
#include "tools/command.h"
#include "tools/scene_options.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace haarfield {

namespace {

struct VerifyOptions {
    std::string field;
};

Result<ExitCode> run(const VerifyOptions& options, const CommandContext& context) {
    HF_TRY_DONE(verify_field(options.field));
    context.print("{}: good\n", options.field);
    return ExitCode::done;
}

}  // namespace

Command verify_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("verify", "Verify all grids and handles of a visibility field");
    const auto options = std::make_shared<VerifyOptions>();
    app->add_option("FIELD", options->field, "The field (.vdb)")->required()->type_name("");
    app->footer(
        "If anything is wrong, prints the reason and exits with code 1.\n"
        "Example:\n  haarfield verify out/chair/fields/chair.vdb");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
