#include "fields/vdb_store.h"
#include "tools/command.h"

#include <fmt/format.h>

namespace haarfield {

Command verify_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("verify", "Check every checksum and handle of a visibility field");
    const auto field = std::make_shared<std::string>();
    app->add_option("FIELD", *field, "The field (.vdb)")->required()->type_name("");
    app->footer(
        "Exit code 1, with the reason, if anything is off.\n"
        "Example:\n  haarfield verify out/chair/fields/chair.vdb");
    return {app, [field](Session&) -> Result<ExitCode> {
                if (const Result<Done> verified = verify_field(*field); !verified) return verified.error();
                fmt::print("{}: good\n", *field);
                return ExitCode::done;
            }};
}

}  // namespace haarfield
