#include "tools/command.h"
#include "tools/farm/task_batches.h"
#include "tools/farm/task_list.h"
#include "tools/number_option.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

struct StatusOptions {
    std::string plan;
    bool json = false, verify = false;
    std::size_t batches = 0, batch_tasks = 1;  // 0: no batches
    std::vector<std::size_t> nodes;
    double overhead = 1;
    bool from_start = false, processor_time = false;
};

std::string time_text(double seconds) {
    if (seconds < 120) return fmt::format("{:.1f} s", seconds);
    if (seconds < 7200) return fmt::format("{:.1f} min", seconds / 60);
    return fmt::format("{:.1f} h", seconds / 3600);
}

/// Prints the tasks to run, one scheduler job per line, and the join.
Result<ExitCode> print_batches(const StatusOptions& options, const FarmPlan& plan,
                               const std::vector<TaskStatus>& states) {
    const Result<std::vector<TaskBatch>> batches =
        task_batches(plan, states, options.batch_tasks, options.batches);
    if (!batches) return Error{"--batches", batches.error().what};
    const auto print_job = [](const std::string& stage, const JobLimits& limits, const std::string& tasks) {
        print(stdout, "{} {} {} {}\n", stage, limits.minutes, limits.megabytes, tasks);
    };
    for (const TaskBatch& batch : *batches)
        print_job(std::to_string(batch.stage + 1), batch.limits, task_list(batch.tasks));
    print_job("join", join_limits(plan, states), "-");
    return ExitCode::done;
}

Result<ExitCode> run(const StatusOptions& options, CommandContext& context) {
    HF_TRY(const FarmPlan plan, read_plan(options.plan));
    const std::vector<TaskStatus> states = task_states(
        options.plan, plan, options.verify ? ResultCheck::content : ResultCheck::length, context.progress);
    if (context.progress.stop.stop_requested()) return interruption();
    if (options.batches > 0) return print_batches(options, plan, states);
    const std::vector<double> seconds =
        task_seconds(plan, states, options.processor_time ? TaskTime::processor : TaskTime::clock);
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
    // Assumes the number of nodes that currently work.
    const auto running = static_cast<std::size_t>(count(TaskState::running));
    nlohmann::ordered_json failures = nlohmann::ordered_json::array(),
                           times = nlohmann::ordered_json::array();
    std::vector<std::size_t> damaged;
    for (std::size_t task = 0; task < states.size(); ++task)
        if (states[task].state == TaskState::damaged) damaged.push_back(task);
    for (std::size_t task = 0; task < states.size(); ++task)
        if (states[task].state == TaskState::failed)
            failures.push_back({{"task", task}, {"failure", states[task].failure}});
    for (const std::size_t nodes : options.nodes)
        times.push_back(
            {{"nodes", nodes}, {"seconds", simulated_seconds(plan, seconds, left, nodes, options.overhead)}});
    nlohmann::ordered_json status{{"plan", options.plan},
                                  {"tasks", states.size()},
                                  {"done", count(TaskState::done)},
                                  {"running", running},
                                  {"failed", count(TaskState::failed)},
                                  {"waiting", count(TaskState::waiting)},
                                  {"damaged", damaged},
                                  {"seconds_left", left_seconds},
                                  {"cpu_seconds", cpu_seconds},
                                  {"peak_bytes", peak_bytes},
                                  {"failures", failures}};
    if (running > 0) status["time_left"] = simulated_seconds(plan, seconds, left, running, options.overhead);
    if (!options.nodes.empty()) status["simulated"] = times;
    context.report["status"] = status;
    const ExitCode code = options.verify && !damaged.empty() ? ExitCode::failed : ExitCode::done;
    if (options.json) {
        print(stdout, "{}\n", status.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
        return code;
    }
    context.print("tasks  {}: {} done, {} running, {} failed, {} damaged, {} waiting\n", states.size(),
                  count(TaskState::done), running, count(TaskState::failed), damaged.size(),
                  count(TaskState::waiting));
    context.print("took   {} of processor time, at most {:.0f} MB per task\n", time_text(cpu_seconds),
                  double(peak_bytes) / 1e6);
    context.print("left   {} on one node", time_text(left_seconds));
    if (running > 0) context.print(", {} with the {} running", time_text(status["time_left"]), running);
    context.print("\n");
    for (const auto& time : times)
        context.print("nodes  {:>6}: {}\n", time["nodes"].get<std::size_t>(), time_text(time["seconds"]));
    for (const auto& failure : failures)
        context.print("failed task {}: {}\n", failure["task"].get<std::size_t>(),
                      failure["failure"].get<std::string>());
    if (!damaged.empty())
        context.print("damaged results: run `haarfield work {} --tasks {}` or the plan's script again\n",
                      options.plan, task_list(damaged));
    return code;
}

}  // namespace

Command status_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("status", "Print the progress of a plan");
    const auto options = std::make_shared<StatusOptions>();
    app->add_option("PLAN", options->plan, "The plan's folder")->required()->type_name("");
    app->add_flag("--json", options->json, "Print JSON");
    app->add_flag(
        "--verify", options->verify,
        "Verify the checksums of all results, not only their lengths; exit code 1 if one is damaged");
    CLI::Option* const batches =
        add_number(
            *app, "--batches", options->batches,
            "Print the tasks to run instead, in at most N scheduler jobs plus the join, as lines STAGE "
            "MINUTES MEGABYTES TASKS, which slurm.sh reads",
            {1, 1e6})
            ->excludes(app->get_option("--json"))
            ->type_name("N");
    add_number(*app, "--batch-tasks", options->batch_tasks, "Minimum number of tasks in each of these jobs",
               {1, 1e6})
        ->needs(batches)
        ->capture_default_str()
        ->type_name("N");
    add_number(
        *app, "--nodes", options->nodes,
        "Simulate the remaining tasks on N nodes with one task at a time each; several numbers possible",
        {1, 1e6})
        ->delimiter(',')
        ->type_name("N,...");
    add_number(*app, "--overhead", options->overhead, "Simulated time of the scheduler per task, in seconds",
               {0, 1e6})
        ->capture_default_str()
        ->type_name("S");
    app->add_flag("--from-start", options->from_start, "Simulate all tasks, including finished ones");
    app->add_flag("--processor-time", options->processor_time,
                  "Use processor time instead of wall time, as on nodes that run nothing else");
    app->footer(
        "Times of unfinished tasks are estimates, corrected by the finished ones. A damaged result counts\n"
        "as not done.\n"
        "Example:\n"
        "  haarfield status out/plan --nodes 10,100,1000");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
