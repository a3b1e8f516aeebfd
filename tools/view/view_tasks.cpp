#include "tools/view/view_tasks.h"

#include "fields/base/exception_message.h"
#include "fields/file/write_file.h"
#include "tools/command.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

namespace haarfield {
namespace {

constexpr auto progress_period = std::chrono::milliseconds(200);
/// Lights of a reference with bounces, whose time grows with their number. With this number the error is
/// about 0.5 %, and the picture takes a third of the time of 1024 lights.
constexpr int lights_that_bounce = 256;

/// Returns the command line of a task.
std::vector<std::string> arguments_of(const std::string& command, const std::filesystem::path& scene,
                                      const TaskSettings& settings, const std::filesystem::path& output) {
    std::vector<std::string> arguments{command, scene.string(), "-o", output.string()};
    if (command != "bake") {
        const int bounces = reference_bounces(settings.render.shading.bounces.most);
        arguments.insert(arguments.end(), {"--bounces", std::to_string(bounces)});
        if (bounces > 0) arguments.insert(arguments.end(), {"--lights", std::to_string(lights_that_bounce)});
        return arguments;
    }
    arguments.insert(arguments.end(), {"--fields", settings.render.entities.fields_folder.string()});
    const std::vector<std::string> given =
        option_arguments(settings.render, {OptionSet::fields, OptionSet::occlusion});
    arguments.insert(arguments.end(), given.begin(), given.end());
    return arguments;
}

/// Runs a command of this program in this process.
Result<ExitCode> run_arguments(std::vector<std::string> arguments, CommandContext& context) {
    CLI::App program;
    const std::vector<Command> commands{bake_command(program), reference_command(program)};
    try {
        std::reverse(arguments.begin(), arguments.end());  // CLI11 expects the reverse order
        program.parse(arguments);
        for (const Command& command : commands)
            if (command.app->parsed()) return command.run(context);
        return Error{"", "unknown command"};
    } catch (const std::exception& exception) {
        return Error{"", exception_message(exception)};
    }
}

}  // namespace

ViewTasks::ViewTasks(TaskSettings settings, std::function<void(const nlohmann::json&)> tell)
    : settings_(std::move(settings)), tell_(std::move(tell)) {}

std::string ViewTasks::add_file(const std::filesystem::path& file) {
    const std::lock_guard lock(mutex_);
    files_[file.filename().string()] = file;
    return file.filename().string();
}

std::optional<std::filesystem::path> ViewTasks::made_file(std::string_view name) const {
    const std::lock_guard lock(mutex_);
    const auto known = files_.find(name);
    if (known == files_.end()) return std::nullopt;
    return known->second;
}

Result<Done> ViewTasks::start(const std::string& command, const std::string& scene_name,
                              std::string scene_text) {
    {
        const std::lock_guard lock(mutex_);
        if (running_) return Error{"", "another task is running; expected one at a time"};
        running_ = true;
    }
    const std::filesystem::path scene = folder_of(command) / (scene_name + ".toml");
    Result<Done> written = make_folder(folder_of(command));
    if (written) written = write_file(scene, scene_text);
    if (!written) {
        const std::lock_guard lock(mutex_);
        running_ = false;
        return written.error();
    }
    thread_ =
        std::jthread([this, command, scene](const std::stop_token& stop) { run(command, scene, stop); });
    return Done{};
}

void ViewTasks::cancel() {
    thread_.request_stop();
    if (thread_.joinable()) thread_.join();
}

void ViewTasks::run(const std::string& command, const std::filesystem::path& scene,
                    const std::stop_token& stop) {
    CommandContext context;
    context.threads = settings_.threads;
    context.quiet = true;
    context.progress.stop = stop;
    auto next = std::chrono::steady_clock::now();
    context.progress.report = [&](std::string_view stage, std::uint64_t done, std::uint64_t total) {
        const auto now = std::chrono::steady_clock::now();
        if (now < next) return;
        next = now + progress_period;
        tell_({{"type", "task"},
               {"task", command},
               {"state", "running"},
               {"stage", stage},
               {"share", total > 0 ? double(done) / double(total) : 0}});
    };
    context.message = [](const std::string&) {};
    context.report = {{"warnings", nlohmann::json::array()}};
    const std::filesystem::path output = folder_of(command);
    const Result<ExitCode> result = run_arguments(arguments_of(command, scene, settings_, output), context);
    nlohmann::json end{{"type", "task"}, {"task", command}};
    if (result) {
        end["state"] = "done";
        end["files"] = nlohmann::json::array();
        std::error_code ignored;
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::directory_iterator(output, ignored))
            if (entry.is_regular_file(ignored)) files.push_back(entry.path());
        std::sort(files.begin(), files.end());
        for (const std::filesystem::path& file : files) end["files"].push_back(add_file(file));
        end["warnings"] = context.report["warnings"];
        if (command == "reference") end["bounces"] = context.report["bounces"];
    } else {
        end["state"] = stop.stop_requested() ? "cancelled" : "failed";
        end["message"] = result.error().message();
    }
    {
        const std::lock_guard lock(mutex_);
        running_ = false;
    }
    tell_(end);
}

}  // namespace haarfield
