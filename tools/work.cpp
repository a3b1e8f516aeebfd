#include "fields/file/claim.h"
#include "fields/file/write_file.h"
#include "tools/farm/job_run.h"
#include "tools/farm/task_list.h"
#include "tools/stopwatch.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <set>

namespace haarfield {

namespace {

struct WorkOptions {
    std::string plan, tasks;
};

/// The most tasks that run together: a killed process loses their results, and each holds a claim.
constexpr std::size_t most_together = 32;

/// Runs a list of tasks.
class Worker {
public:
    Worker(const FarmPlan& plan, const std::filesystem::path& folder, CommandContext& context)
        : plan_(plan), folder_(folder), context_(context) {}

    /// Runs the tasks without a good result. Continues after failures.
    ///
    /// tasks   in ascending order.
    /// errors  the first failure.
    Result<Done> run(const std::vector<std::size_t>& tasks) {
        Result<Done> result = Done{};
        for (const std::vector<std::size_t>& together : groups(unfinished(tasks))) {
            Result<Done> done = run_together(together);
            if (!done && context_.progress.stop.stop_requested()) return done;
            if (!done && !result) context_.message(done.error().message());
            if (!done && result) result = std::move(done);
        }
        return result;
    }

    double cpu_seconds() const { return cpu_seconds_; }
    std::uint64_t peak_bytes() const { return peak_bytes_; }

private:
    /// Returns the tasks without a good result.
    std::vector<std::size_t> unfinished(const std::vector<std::size_t>& tasks) const {
        std::vector<std::size_t> left;
        for (const std::size_t task : tasks) {
            const Result<TaskPart> part = read_part(folder_, plan_, task);
            if (part)
                context_.print("task   {} was already done on {}\n", task, part->cost.host);
            else
                left.push_back(task);
        }
        return left;
    }

    /// Groups consecutive tasks of one job.
    std::vector<std::vector<std::size_t>> groups(const std::vector<std::size_t>& tasks) const {
        std::vector<std::vector<std::size_t>> result;
        for (const std::size_t task : tasks) {
            const bool follows = !result.empty() && result.back().back() + 1 == task &&
                                 result.back().size() < most_together &&
                                 plan_.task(task).job == plan_.task(result.back().back()).job;
            if (!follows) result.emplace_back();
            result.back().push_back(task);
        }
        return result;
    }

    Result<Done> run_together(const std::vector<std::size_t>& tasks) {
        // Waits for other processes that run these tasks. Claims are made in ascending order, which prevents
        // deadlocks.
        std::vector<Claim> claims;
        for (const std::size_t task : tasks) {
            HF_TRY(std::optional<Claim> claim,
                   Claim::on(task_file(folder_, task, "claim"), context_.progress));
            if (claim) claims.push_back(*std::move(claim));
        }
        for (const std::vector<std::size_t>& left : groups(unfinished(tasks))) HF_TRY_DONE(run_claimed(left));
        return Done{};
    }

    Result<Done> run_claimed(const std::vector<std::size_t>& tasks) {
        const PlanTask first = plan_.task(tasks.front());
        Result<Done> done = published({first.job, first.part, tasks.size()}, tasks.front());
        std::error_code none;
        for (const std::size_t task : tasks) {
            const std::filesystem::path failed = task_file(folder_, task, "failed");
            if (done)
                std::filesystem::remove(failed, none);
            else if (!context_.progress.stop.stop_requested())
                (void)write_file(failed, done.error().message() + "\n");  // read by `status`
        }
        return done;
    }

    /// Computes and publishes the results.
    Result<Done> published(const PlanTasks& tasks, std::size_t first) {
        if (checked_jobs_.insert(tasks.job).second)
            if (Result<Done> same = check_inputs(plan_.jobs[tasks.job]); !same) {
                checked_jobs_.erase(tasks.job);
                return same;
            }
        const Stopwatch watch;
        CommandContext inner = context_;
        inner.quiet = true;
        HF_TRY(PartSections made, done_tasks(plan_, tasks, folder_, inner));
        // The cost is that of all tasks of the group.
        TaskCost cost = process_cost(watch.elapsed().wall);
        const double cpu_seconds = cost.cpu_seconds - cpu_seconds_;
        cpu_seconds_ = cost.cpu_seconds;
        peak_bytes_ = cost.peak_bytes;
        const double seconds = cost.seconds;
        cost.seconds /= double(tasks.count);
        cost.cpu_seconds = cpu_seconds / double(tasks.count);
        for (std::size_t k = 0; k < tasks.count; ++k)
            HF_TRY_DONE(write_part(folder_, plan_, first + k, {cost, std::move(made[k])}));
        if (tasks.count == 1)
            context_.print("task   {} done in {:.2f} s, {:.2f} s of processor time, {:.0f} MB\n", first,
                           seconds, cpu_seconds, double(cost.peak_bytes) / 1e6);
        else
            context_.print("tasks  {}-{} done in {:.2f} s, {:.2f} s of processor time, {:.0f} MB\n", first,
                           first + tasks.count - 1, seconds, cpu_seconds, double(cost.peak_bytes) / 1e6);
        return Done{};
    }

    const FarmPlan& plan_;
    std::filesystem::path folder_;
    CommandContext& context_;
    std::set<std::size_t> checked_jobs_;  // jobs whose inputs have been checked
    double cpu_seconds_ = 0;              // of this process so far
    std::uint64_t peak_bytes_ = 0;
};

Result<ExitCode> run(const WorkOptions& options, CommandContext& context) {
    HF_TRY(const FarmPlan plan, read_plan(options.plan));
    const Result<std::vector<std::size_t>> tasks = listed_tasks(options.tasks, plan.task_count());
    if (!tasks) return Error{"--tasks", tasks.error().what};
    HF_TRY_DONE(enter_plan(plan));
    Worker worker(plan, options.plan, context);
    HF_TRY_DONE(worker.run(*tasks));
    context.report["tasks"] = *tasks;
    context.report["cpu_seconds"] = worker.cpu_seconds();
    context.report["peak_bytes"] = worker.peak_bytes();
    return ExitCode::done;
}

std::string list_trouble(const std::string& text) {
    return is_task_list(text) ? "" : fmt::format("is {}; expected numbers and ranges, such as 0-9,12", text);
}

}  // namespace

Command work_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("work", "Run tasks of a plan");
    const auto options = std::make_shared<WorkOptions>();
    app->add_option("PLAN", options->plan, "The plan's folder")->required()->type_name("");
    app->add_option("--task,--tasks", options->tasks,
                    "Tasks to run, counted from 0: numbers and ranges, separated by commas")
        ->required()
        ->check(CLI::Validator(list_trouble, ""))
        ->type_name("LIST");
    app->footer(
        "Skips tasks that have a good result. Consecutive tasks of one job start and prepare the scene "
        "once.\n"
        "The command may be killed at any time, and may run several times at once on any machine that has\n"
        "the plan's folder and the scene's files under the same names.\n"
        "Example:\n  haarfield work out/plan --task 7\n  haarfield work out/plan --tasks 0-9,12");
    return {app, [options](CommandContext& context) {
                options->plan = std::filesystem::absolute(options->plan).string();  // tasks go elsewhere
                return run(*options, context);
            }};
}

}  // namespace haarfield
