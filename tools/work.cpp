#include "fields/file/claim.h"
#include "fields/file/write_file.h"
#include "tools/farm/job_run.h"
#include "tools/number_option.h"
#include "tools/stopwatch.h"

#include <fmt/format.h>

namespace haarfield {

namespace {

struct WorkOptions {
    std::string plan;
    std::size_t task = 0;
};

/// The task, and what it took.
Result<TaskPart> done(const FarmPlan& plan, const WorkOptions& options, CommandContext& context) {
    const PlanTask task = plan.task(options.task);
    if (const Result<Done> same = check_inputs(plan.jobs[task.job]); !same) return same.error();
    const Stopwatch watch;
    CommandContext inner = context;
    inner.quiet = true;
    Result<std::vector<Section>> sections = done_task(plan, task, options.plan, inner);
    if (!sections) return sections.error();
    return TaskPart{process_cost(watch.elapsed().wall), *std::move(sections)};
}

Result<ExitCode> run(const WorkOptions& options, CommandContext& context) {
    const Result<FarmPlan> plan = read_plan(options.plan);
    if (!plan) return plan.error();
    if (options.task >= plan->task_count())
        return Error{"--task",
                     fmt::format("is {}; the plan has tasks 0 to {}", options.task, plan->task_count() - 1)};
    const auto is_done = [&] {
        const Result<TaskPart> part = read_part(options.plan, *plan, options.task);
        if (part) context.print("task   {} is done already, on {}\n", options.task, part->cost.host);
        return bool(part);
    };
    if (is_done()) return ExitCode::done;
    // While another process is at this task, wait for it: a result that is there need not be made.
    const Result<std::optional<Claim>> claim =
        Claim::on(task_file(options.plan, options.task, "claim"), context.progress);
    if (!claim) return claim.error();
    if (is_done()) return ExitCode::done;
    if (const Result<Done> entered = enter_plan(*plan); !entered) return entered.error();
    const std::filesystem::path failed = task_file(options.plan, options.task, "failed");
    Result<TaskPart> part = done(*plan, options, context);
    if (part)
        if (const Result<Done> written = write_part(options.plan, *plan, options.task, *part); !written)
            part = written.error();
    if (!part) {
        if (!context.progress.stop.stop_requested())
            (void)write_file(failed, part.error().message() + "\n");  // `status` tells it
        return part.error();
    }
    std::error_code none;
    std::filesystem::remove(failed, none);
    context.report["task"] = options.task;
    context.report["cpu_seconds"] = part->cost.cpu_seconds;
    context.report["peak_bytes"] = part->cost.peak_bytes;
    context.print("task   {} done in {:.2f} s, {:.2f} s of all cores, {:.0f} MB\n", options.task,
                  part->cost.seconds, part->cost.cpu_seconds, double(part->cost.peak_bytes) / 1e6);
    return ExitCode::done;
}

}  // namespace

Command work_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("work", "Do one task of a plan");
    const auto options = std::make_shared<WorkOptions>();
    app->add_option("PLAN", options->plan, "The plan's folder")->required()->type_name("");
    add_number(*app, "--task", options->task, "Which task, counted from 0", {0, 1e9})
        ->required()
        ->type_name("K");
    app->footer(
        "Does nothing if the task's result is there and good. It may be killed at any time, and run several\n"
        "times at once, on any machine that has the plan's folder and the scene's files under the same "
        "names.\n"
        "Example:\n  haarfield work out/plan --task 7");
    return {app, [options](CommandContext& context) {
                options->plan = std::filesystem::absolute(options->plan).string();  // tasks go elsewhere
                return run(*options, context);
            }};
}

}  // namespace haarfield
