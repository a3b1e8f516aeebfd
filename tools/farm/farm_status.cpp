#include "tools/farm/farm_status.h"

#include <algorithm>
#include <array>
#include <functional>
#include <queue>

#include "fields/file/input_file.h"
#include "fields/file/process_name.h"

namespace haarfield {
namespace {

std::string text_of(const std::filesystem::path& file) {
    constexpr std::uint64_t largest = std::uint64_t{1} << 20;
    const Result<std::string> text = read_whole_file(file, largest);
    return text ? *text : "";
}

bool is_running(const std::filesystem::path& claim) {
    std::error_code none;
    const auto renewed = std::filesystem::last_write_time(claim, none);
    if (none) return false;
    const Liveness liveness = process_liveness(text_of(claim));
    return liveness == Liveness::alive ||
           (liveness == Liveness::unknown &&
            std::filesystem::file_time_type::clock::now() - renewed < std::chrono::seconds(60));
}

/// Returns the cost of a task whose result passes the check.
std::optional<TaskCost> checked_cost(const std::filesystem::path& folder, const FarmPlan& plan,
                                     std::size_t task, ResultCheck check) {
    if (check == ResultCheck::length) return part_cost(folder, plan, task);
    Result<TaskPart> part = read_part(folder, plan, task);
    return part ? std::optional(std::move(part->cost)) : std::nullopt;
}

}  // namespace

std::vector<TaskStatus> task_states(const std::filesystem::path& folder, const FarmPlan& plan,
                                    ResultCheck check, const Progress& progress) {
    std::vector<TaskStatus> states(plan.task_count());
    for (std::size_t task = 0; task < states.size(); ++task) {
        if (progress.stop.stop_requested()) break;
        if (progress.report && check == ResultCheck::content)
            progress.report("checking results", task + 1, states.size());
        TaskStatus& status = states[task];
        std::error_code none;
        if (std::optional<TaskCost> cost = checked_cost(folder, plan, task, check)) {
            status.state = TaskState::done;
            status.cost = *std::move(cost);
        } else if (is_running(task_file(folder, task, "claim"))) {
            status.state = TaskState::running;
        } else if (std::filesystem::exists(task_file(folder, task, "part"), none)) {
            status.state = TaskState::damaged;
        } else if (const auto failed = task_file(folder, task, "failed");
                   std::filesystem::exists(failed, none)) {
            status.state = TaskState::failed;
            status.failure = text_of(failed);
            while (!status.failure.empty() && status.failure.back() == '\n') status.failure.pop_back();
        }
    }
    return states;
}

std::vector<double> task_seconds(const FarmPlan& plan, const std::vector<TaskStatus>& states, TaskTime time) {
    const auto took = [&](const TaskStatus& status) {
        return time == TaskTime::clock ? status.cost.seconds : status.cost.cpu_seconds / plan.threads;
    };
    constexpr std::size_t kinds = static_cast<std::size_t>(Division::undivided) + 1;
    std::array<double, kinds> estimated{}, taken{};
    std::vector<double> seconds;
    for (std::size_t j = 0; j < plan.jobs.size(); ++j)
        for (std::size_t part = 0; part < plan.jobs[j].parts; ++part) {
            const auto kind = static_cast<std::size_t>(plan.jobs[j].division);
            const TaskStatus& status = states[seconds.size()];
            seconds.push_back(plan.jobs[j].part_seconds);
            if (status.state != TaskState::done) continue;
            estimated[kind] += seconds.back();
            taken[kind] += took(status);
        }
    std::size_t task = 0;
    for (const PlanJob& job : plan.jobs)
        for (std::size_t part = 0; part < job.parts; ++part, ++task) {
            const auto kind = static_cast<std::size_t>(job.division);
            if (states[task].state == TaskState::done)
                seconds[task] = took(states[task]);
            else if (estimated[kind] > 0)
                seconds[task] *= taken[kind] / estimated[kind];
        }
    return seconds;
}

double simulated_seconds(const FarmPlan& plan, const std::vector<double>& seconds,
                         const std::vector<bool>& left, std::size_t nodes, double overhead) {
    double stage_begin = 0;
    for (std::size_t stage = 0; stage + 1 < plan.stages.size(); ++stage) {
        std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
        for (std::size_t node = 0; node < nodes; ++node) free_at.push(stage_begin);
        double end = stage_begin;
        for (std::size_t task = plan.stages[stage]; task < plan.stages[stage + 1]; ++task) {
            if (!left[task]) continue;
            const double done = free_at.top() + seconds[task] + overhead;
            free_at.pop();
            free_at.push(done);
            end = std::max(end, done);
        }
        stage_begin = end;
    }
    return stage_begin;
}

}  // namespace haarfield
