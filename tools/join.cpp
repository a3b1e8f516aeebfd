#include "tools/farm/job_run.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace haarfield {

namespace {

struct JoinOptions {
    std::string plan;
};

/// Checks that the results of all tasks are good.
///
/// errors  lists the tasks without a good result.
Result<Done> check_parts(const FarmPlan& plan, const JoinOptions& options, CommandContext& context) {
    constexpr std::size_t most_named = 10;
    std::size_t bad = 0;
    nlohmann::ordered_json numbers = nlohmann::ordered_json::array();
    std::string named;
    for (std::size_t task = 0; task < plan.task_count(); ++task) {
        if (context.progress.stop.stop_requested()) return interruption();
        const Result<TaskPart> part = read_part(options.plan, plan, task);
        if (context.progress.report)
            context.progress.report("verifying results", task + 1, plan.task_count());
        if (part) continue;
        numbers.push_back(task);
        if (bad++ < most_named) named += fmt::format("\n  task {}: {}", task, part.error().message());
    }
    context.report["bad_tasks"] = numbers;
    if (bad == 0) return Done{};
    if (bad > most_named) named += fmt::format("\n  and {} more", bad - most_named);
    return Error{options.plan,
                 fmt::format("{} of {} tasks have no good result; run `haarfield work {} --task K` "
                             "for each of them:{}",
                             bad, plan.task_count(), options.plan, named)};
}

Result<ExitCode> run(const JoinOptions& options, CommandContext& context) {
    HF_TRY(const FarmPlan plan, read_plan(options.plan));
    HF_TRY_DONE(check_parts(plan, options, context));
    HF_TRY_DONE(enter_plan(plan));
    for (std::size_t job = 0; job < plan.jobs.size(); ++job) {
        if (context.progress.stop.stop_requested()) return interruption();
        HF_TRY_DONE(check_inputs(plan.jobs[job]));
        CommandContext inner = context;
        inner.quiet = context.quiet || plan.jobs[job].division == Division::samples;
        HF_TRY_DONE(join_job(plan, job, options.plan, inner));
        context.report["warnings"] = inner.report["warnings"];
    }
    context.report["tasks"] = plan.task_count();
    context.print("joined {} tasks of {} jobs\n", plan.task_count(), plan.jobs.size());
    return ExitCode::done;
}

}  // namespace

Command join_command(CLI::App& program) {
    CLI::App* app =
        program.add_subcommand("join", "Verify the results of a plan's tasks and write the final files");
    const auto options = std::make_shared<JoinOptions>();
    app->add_option("PLAN", options->plan, "The plan's folder")->required()->type_name("");
    app->footer(
        "The results are byte-identical to those of the undivided commands. If a result is missing or\n"
        "damaged, prints the number of its task and exits with code 1: run that task again.\n"
        "Example:\n  haarfield join out/plan");
    return {app, [options](CommandContext& context) {
                options->plan = std::filesystem::absolute(options->plan).string();  // tasks go elsewhere
                return run(*options, context);
            }};
}

}  // namespace haarfield
