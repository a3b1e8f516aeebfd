#include "tools/command.h"

#include "fields/base/exception_message.h"
#include "fields/file/reader_process.h"
#include "fields/file/write_file.h"
#include "tools/interrupt.h"
#include "tools/number_option.h"
#include "tools/progress_bar.h"
#include "tools/render_options.h"
#include "tools/stopwatch.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

namespace haarfield {

namespace {

// Reports exceptions (out of memory, a library's exception) as messages instead of aborting.
Result<ExitCode> guarded_run(const Command& command, CommandContext& context) {
    try {
        return command.run(context);
    } catch (const std::exception& exception) {
        return Error{"", exception_message(exception)};
    }
}

/// Prints the first line of each description. The manual page has all lines.
class BriefHelp : public CLI::Formatter {
public:
    std::string make_option_desc(const CLI::Option* option) const override {
        const std::string text = option->get_description();
        return text.substr(0, text.find('\n'));
    }
};

}  // namespace

void CommandContext::warn(const std::string& text) {
    report["warnings"].push_back(text);
    message("warning: " + text);
}

void add_common_options(CLI::App& command, CommonOptions& options) {
    add_number(command, "--threads", options.threads, "Number of threads (default: one per core)", {1, 1024})
        ->type_name("N")
        ->group(speed_group);
    command.add_flag("--quiet", options.quiet, "Print only errors, and the output of --json");
    command.add_option("--report", options.report, "Write a report with counts and times as JSON")
        ->type_name("FILE.json")
        ->group(files_group);
    command
        .add_flag("--unsandboxed", options.unsandboxed,
                  "Accept readers of models and images without a sandbox\nFor systems that cannot sandbox "
                  "the readers. Only for files that you trust.")
        ->group(files_group);
}

std::vector<Command> all_commands(CLI::App& program, CommonOptions& options) {
    program.formatter(std::make_shared<BriefHelp>());  // subcommands that are added later inherit it
    std::vector<Command> commands;
    for (const auto make :
         {import_command, precompute_command, bake_command, reference_command, compare_command, probe_command,
          budget_command, residual_command, relight_command, info_command, verify_command, library_command,
          plan_command, work_command, join_command, status_command, view_command}) {
        commands.push_back(make(program));
        add_common_options(*commands.back().app, options);
    }
    return commands;
}

ExitCode run_command(const Command& command, const CommonOptions& options, const std::string& command_line) {
    const std::string name = "haarfield " + command.app->get_name();
    std::stop_source stop;
    stop_on_interrupt(stop);
    ProgressBar bar(options.quiet);
    if (options.unsandboxed) allow_unsandboxed_readers();
    const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));

    CommandContext context;
    context.threads = threads;
    context.quiet = options.quiet;
    context.unsandboxed = options.unsandboxed;
    context.progress.stop = stop.get_token();
    context.progress.report = [&bar](std::string_view stage, std::uint64_t done, std::uint64_t total) {
        bar.report(stage, done, total);
    };
    context.command_line = command_line;
    context.message = [&](const std::string& text) {
        if (!options.quiet) bar.message(name + ": " + text);
    };
    context.report = {{"command", command.app->get_name()},
                      {"command_line", command_line},
                      {"version", HAARFIELD_VERSION},
                      {"threads", threads},
                      {"warnings", nlohmann::json::array()}};

    // The tasks of a plan change to the folder in which the plan was made.
    const std::filesystem::path report =
        options.report.empty() ? std::filesystem::path() : std::filesystem::absolute(options.report);
    const Stopwatch watch;
    const Result<ExitCode> result = guarded_run(command, context);
    ExitCode code = result ? *result : ExitCode::failed;
    if (!result && (stop.stop_requested() || result.error().code == ErrorCode::interrupted)) {
        bar.message(name + ": interrupted");
        return ExitCode::stopped;
    }
    if (!result) {
        context.report["error"] = result.error().message();
        bar.message(name + ": " + result.error().message());
    }
    if (!report.empty()) {
        report_time(context.report, "", watch.elapsed());
        context.report["exit_code"] = static_cast<int>(code);
        // File names may contain any bytes; JSON must be UTF-8.
        const std::string text =
            context.report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
        if (const Result<Done> written = write_file(report, text); !written) {
            bar.message(name + ": " + written.error().message());
            if (code == ExitCode::done) code = ExitCode::failed;
        }
    }
    return code;
}

std::string quoted_command_line(int count, const char* const* arguments) {
    std::string line;
    for (int i = 0; i < count; ++i) {
        const std::string_view argument = arguments[i];
        const bool plain = !argument.empty() && argument.find_first_not_of(
                                                    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                                    "0123456789_-+=.,:/@%") == std::string_view::npos;
        if (i > 0) line += ' ';
        if (plain) {
            line += argument;
            continue;
        }
        line += '\'';
        for (const char c : argument) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
        line += '\'';
    }
    return line;
}

}  // namespace haarfield
