#include "tools/command.h"
#include "tools/farm/farm_status.h"
#include "tools/number_option.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

struct StatusOptions {
    std::string plan;
    bool json = false;
    std::vector<std::size_t> nodes;
    double overhead = 1;
    bool from_start = false, processor_time = false;
};

std::string time_text(double seconds) {
    if (seconds < 120) return fmt::format("{:.1f} s", seconds);
    if (seconds < 7200) return fmt::format("{:.1f} min", seconds / 60);
    return fmt::format("{:.1f} h", seconds / 3600);
}

Result<ExitCode> run(const StatusOptions& options, CommandContext& context) {
    const Result<FarmPlan> plan = read_plan(options.plan);
    if (!plan) return plan.error();
    const std::vector<TaskStatus> states = task_states(options.plan, *plan);
    const std::vector<double> seconds =
        task_seconds(*plan, states, options.processor_time ? TaskTime::processor : TaskTime::clock);
    const auto count = [&](TaskState state) { return std::ranges::count(states, state, &TaskStatus::state); };
    std::vector<bool> left;
    double left_seconds = 0, cpu_seconds = 0;
    std::uint64_t peak_bytes = 0;
    for (std::size_t task = 0; task < states.size(); ++task) {
        left.push_back(options.from_start || states[task].state != TaskState::done);
        if (left.back()) left_seconds += seconds[task];
        cpu_seconds += states[task].cost.cpu_seconds;
        peak_bytes = std::max(peak_bytes, states[task].cost.peak_bytes);
    }
    // With as many nodes as are at work now.
    const auto running = static_cast<std::size_t>(count(TaskState::running));
    nlohmann::ordered_json failures = nlohmann::ordered_json::array(),
                           times = nlohmann::ordered_json::array();
    for (std::size_t task = 0; task < states.size(); ++task)
        if (states[task].state == TaskState::failed)
            failures.push_back({{"task", task}, {"failure", states[task].failure}});
    for (const std::size_t nodes : options.nodes)
        times.push_back({{"nodes", nodes},
                         {"seconds", simulated_seconds(*plan, seconds, left, nodes, options.overhead)}});
    nlohmann::ordered_json status{{"plan", options.plan},
                                  {"tasks", states.size()},
                                  {"done", count(TaskState::done)},
                                  {"running", running},
                                  {"failed", count(TaskState::failed)},
                                  {"waiting", count(TaskState::waiting)},
                                  {"seconds_left", left_seconds},
                                  {"cpu_seconds", cpu_seconds},
                                  {"peak_bytes", peak_bytes},
                                  {"failures", failures}};
    if (running > 0) status["time_left"] = simulated_seconds(*plan, seconds, left, running, options.overhead);
    if (!options.nodes.empty()) status["simulated"] = times;
    context.report["status"] = status;
    if (options.json) {
        fmt::print("{}\n", status.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
        return ExitCode::done;
    }
    context.print("tasks  {}: {} done, {} running, {} failed, {} waiting\n", states.size(),
                  count(TaskState::done), running, count(TaskState::failed), count(TaskState::waiting));
    context.print("took   {} of all cores, at most {:.0f} MB a task\n", time_text(cpu_seconds),
                  double(peak_bytes) / 1e6);
    context.print("left   {} of one node", time_text(left_seconds));
    if (running > 0) context.print(", {} with the {} at work", time_text(status["time_left"]), running);
    context.print("\n");
    for (const auto& time : times)
        context.print("nodes  {:>6}: {}\n", time["nodes"].get<std::size_t>(), time_text(time["seconds"]));
    for (const auto& failure : failures)
        context.print("failed task {}: {}\n", failure["task"].get<std::size_t>(),
                      failure["failure"].get<std::string>());
    return ExitCode::done;
}

}  // namespace

Command status_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("status", "Say how far a plan is");
    const auto options = std::make_shared<StatusOptions>();
    app->add_option("PLAN", options->plan, "The plan's folder")->required()->type_name("");
    app->add_flag("--json", options->json, "As JSON");
    add_number(*app, "--nodes", options->nodes,
               "Simulate what is left on so many nodes, separated by commas, each doing one task at a time",
               {1, 1e6})
        ->delimiter(',')
        ->type_name("N,...");
    add_number(*app, "--overhead", options->overhead, "What the scheduler takes for a task there, in seconds",
               {0, 1e6})
        ->capture_default_str()
        ->type_name("S");
    app->add_flag("--from-start", options->from_start, "Simulate all tasks, also those that are done");
    app->add_flag("--processor-time", options->processor_time,
                  "Take the processor's time for that of the clock, as on nodes that do nothing else");
    app->footer(
        "Times of tasks that are not done are estimates, corrected by those that are.\n"
        "Example:\n  haarfield status out/plan --nodes 10,100,1000");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
