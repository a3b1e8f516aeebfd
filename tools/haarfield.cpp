// haarfield: the program. Each subcommand is implemented in its own file; this file selects the subcommand.

#include "tools/command.h"
#include "tools/surroundings.h"
#ifdef HAARFIELD_READS_IMAGES
#include "scenes/image_reader.h"
#endif

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <vector>

namespace haarfield {
namespace {

ExitCode run_program(int argument_count, const char* const* arguments) {
    CLI::App program{
        "Bakes environment light, local lights and indirect light into vertex colours for POV-Ray.",
        "haarfield"};
    program.set_version_flag("--version", "haarfield " HAARFIELD_VERSION);
    program.require_subcommand(1);
    program.footer(
        "Example:\n  haarfield bake scenes/single_chair.toml -o out/chair\n"
        "`haarfield COMMAND --help` lists options. Exit code: 0 done, 1 bad input or failed work,\n"
        "2 bad usage, 3 images differ more than allowed, 130 interrupted.");
    CommonOptions options;
    const std::vector<Command> commands = all_commands(program, options);
    try {
        program.parse(argument_count, arguments);
    } catch (const CLI::Success& help_or_version) {
        program.exit(help_or_version);
        return ExitCode::done;
    } catch (const CLI::ParseError& error) {
        program.exit(error);
        return ExitCode::bad_usage;
    }
    for (const Command& command : commands)
        if (command.app->parsed())
            return run_command(command, options, quoted_command_line(argument_count, arguments));
    return ExitCode::bad_usage;  // not reached: a subcommand is required
}

}  // namespace
}  // namespace haarfield

int main(int argument_count, char** arguments) {
    haarfield::tidy_surroundings();
    // stdout is line-buffered, so that results and messages stay in order in a common log.
    std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
#ifdef HAARFIELD_READS_IMAGES
    haarfield::read_images_in_this_process();
#endif
    const haarfield::ExitCode code = haarfield::run_program(argument_count, arguments);
    // A full disk or a closed pipe is reported once, for everything that was printed.
    const bool is_printed = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
    if (!is_printed && code == haarfield::ExitCode::done) {
        haarfield::print(stderr, "haarfield: the results could not be written\n");
        return static_cast<int>(haarfield::ExitCode::failed);
    }
    return static_cast<int>(code);
}
