#pragma once
/// Shared parts of all commands: exit codes, common options, messages and the --report file.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "tools/print_text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace haarfield {

enum class ExitCode : int {
    done = 0,
    failed = 1,         ///< Bad input or failed work.
    bad_usage = 2,      ///< A bad command line.
    images_differ = 3,  ///< PSNR below `compare --min-psnr`, or a `residual` above its limits.
    stopped = 130,      ///< The exit code of a shell after SIGINT.
};

struct TaskShare;

/// The environment of a running command.
struct CommandContext {
    int threads = 0;  ///< The number of threads in use, > 0.
    Progress progress;
    std::string command_line;                              ///< The command line in shell syntax.
    nlohmann::ordered_json report;                         ///< Written by --report; commands add their keys.
    std::function<void(const std::string& text)> message;  ///< Writes to stderr; nothing with --quiet.
    bool quiet = false;                                    ///< --quiet
    bool unsandboxed = false;                              ///< --unsandboxed
    TaskShare* share = nullptr;  ///< For a part of a plan's job; null: the command does all of its work.

    /// Prints a result to stdout; nothing with --quiet.
    template <class... Values>
    void print(fmt::format_string<Values...> format, Values&&... values) const {
        if (!quiet) haarfield::print(stdout, format, std::forward<Values>(values)...);
    }

    /// Writes a warning to stderr and into the report.
    void warn(const std::string& text);
};

/// A subcommand. Its options are parsed into data that `run` holds.
struct Command {
    CLI::App* app = nullptr;
    /// Does the work. The caller reports errors.
    std::function<Result<ExitCode>(CommandContext&)> run;
};

/// Each function adds its subcommand to the program. The file of the same name holds its options, help and
/// work.
Command import_command(CLI::App& program);
Command precompute_command(CLI::App& program);
Command probe_command(CLI::App& program);
Command bake_command(CLI::App& program);
Command reference_command(CLI::App& program);
Command compare_command(CLI::App& program);
Command budget_command(CLI::App& program);
Command residual_command(CLI::App& program);
Command relight_command(CLI::App& program);
Command info_command(CLI::App& program);
Command verify_command(CLI::App& program);
Command library_command(CLI::App& program);
Command plan_command(CLI::App& program);
Command work_command(CLI::App& program);
Command join_command(CLI::App& program);
Command status_command(CLI::App& program);
Command view_command(CLI::App& program);

/// Options that all subcommands have.
struct CommonOptions {
    int threads = 0;  ///< 0: all cores.
    bool quiet = false;
    std::string report;
    bool unsandboxed = false;
};
void add_common_options(CLI::App& command, CommonOptions& options);

/// Adds all subcommands, with the common options.
std::vector<Command> all_commands(CLI::App& program, CommonOptions& options);

/// Runs a command after its options have been parsed. Handles threads, progress, Ctrl-C, messages, report and
/// exit code.
ExitCode run_command(const Command& command, const CommonOptions& options, const std::string& command_line);

/// Returns the command line, quoted for a shell where necessary.
std::string quoted_command_line(int count, const char* const* arguments);

}  // namespace haarfield
