#pragma once
/// What all commands have in common: exit codes, common options, messages and the --report file.

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
    failed = 1,         ///< Bad input, or work that could not be done.
    bad_usage = 2,      ///< Of the command line.
    images_differ = 3,  ///< More than `compare --min-psnr` allows.
    stopped = 130,      ///< As a shell reports SIGINT.
};

struct TaskShare;

/// What a command is given when it runs.
struct CommandContext {
    int threads = 0;  ///< In use, > 0.
    Progress progress;
    std::string command_line;                              ///< As a person would type it.
    nlohmann::ordered_json report;                         ///< What --report writes; commands add their keys.
    std::function<void(const std::string& text)> message;  ///< To stderr; nothing if --quiet.
    bool quiet = false;                                    ///< --quiet
    bool unsandboxed = false;                              ///< --unsandboxed
    TaskShare* share = nullptr;  ///< Of a plan's job that is done in parts; null: all of it is done.

    /// A result, to stdout; nothing if --quiet.
    template <class... Values>
    void print(fmt::format_string<Values...> format, Values&&... values) const {
        if (!quiet) haarfield::print(stdout, format, std::forward<Values>(values)...);
    }

    /// To stderr and into the report.
    void warn(const std::string& text);
};

/// A subcommand: its options are parsed into what `run` holds.
struct Command {
    CLI::App* app = nullptr;
    /// Does the work. An Error is reported by the caller.
    std::function<Result<ExitCode>(CommandContext&)> run;
};

/// Each adds its subcommand to the program; the file of the same name holds its options, help and work.
Command import_command(CLI::App& program);
Command precompute_command(CLI::App& program);
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

/// Options that every subcommand has.
struct CommonOptions {
    int threads = 0;  ///< 0: all cores.
    bool quiet = false;
    std::string report;
    bool unsandboxed = false;
};
void add_common_options(CLI::App& command, CommonOptions& options);

/// Adds all subcommands, with the options that each of them has.
std::vector<Command> all_commands(CLI::App& program, CommonOptions& options);

/// Runs a command whose options have been parsed: threads, progress, Ctrl-C, messages, report, exit code.
ExitCode run_command(const Command& command, const CommonOptions& options, const std::string& command_line);

/// The command line, quoted where a shell wants it.
std::string quoted_command_line(int count, const char* const* arguments);

}  // namespace haarfield
