#include "tools/farm/task_batches.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace haarfield {
namespace {

/// Returns limits with margins: estimated times are right to a factor of two, memory less so, and slow nodes
/// need twice the time.
JobLimits limits_of(double seconds, double bytes) {
    constexpr double time_margin = 4, least_seconds = 600, memory_margin = 2, most = 1e9;
    return {static_cast<int>(std::min(most, std::ceil((time_margin * seconds + least_seconds) / 60))),
            static_cast<int>(std::min(most, std::ceil(memory_margin * bytes / 1e6)))};
}

/// Returns the memory per task of each job: the largest measured one, or the estimate if no task is done.
/// [bytes]
std::vector<double> job_bytes(const FarmPlan& plan, const std::vector<TaskStatus>& states) {
    std::vector<double> bytes;
    std::size_t task = 0;
    for (const PlanJob& job : plan.jobs) {
        double most = 0;
        for (std::size_t part = 0; part < job.parts; ++part, ++task)
            if (states[task].state == TaskState::done)
                most = std::max(most, double(states[task].cost.peak_bytes));
        bytes.push_back(most > 0 ? most : job.part_bytes);
    }
    return bytes;
}

using StageTasks = std::array<std::vector<std::size_t>, std::tuple_size_v<decltype(FarmPlan::stages)> - 1>;

StageTasks tasks_to_run(const FarmPlan& plan, const std::vector<TaskStatus>& states) {
    StageTasks tasks;
    for (std::size_t stage = 0; stage < tasks.size(); ++stage)
        for (std::size_t task = plan.stages[stage]; task < plan.stages[stage + 1]; ++task)
            if (states[task].state != TaskState::done && states[task].state != TaskState::running)
                tasks[stage].push_back(task);
    return tasks;
}

std::size_t batch_count(const StageTasks& stages, std::size_t tasks_in_a_batch) {
    std::size_t count = 0;
    for (const std::vector<std::size_t>& tasks : stages)
        count += (tasks.size() + tasks_in_a_batch - 1) / tasks_in_a_batch;
    return count;
}

}  // namespace

Result<std::vector<TaskBatch>> task_batches(const FarmPlan& plan, const std::vector<TaskStatus>& states,
                                            std::size_t least, std::size_t most) {
    const StageTasks stages = tasks_to_run(plan, states);
    if (const std::size_t fewest = batch_count(stages, plan.task_count()); fewest > most)
        return Error{"", fmt::format("is {}; expected at least {}, one for each stage to run", most, fewest)};
    std::size_t size = least;
    while (batch_count(stages, size) > most) ++size;
    const std::vector<double> seconds = task_seconds(plan, states), bytes = job_bytes(plan, states);
    std::vector<TaskBatch> batches;
    for (std::size_t stage = 0; stage < stages.size(); ++stage)
        for (std::size_t first = 0; first < stages[stage].size(); first += size) {
            const std::size_t end = std::min(first + size, stages[stage].size());
            TaskBatch batch{
                stage,
                {stages[stage].begin() + std::ptrdiff_t(first), stages[stage].begin() + std::ptrdiff_t(end)},
                {}};
            double sum = 0, largest = 0;
            for (const std::size_t task : batch.tasks) {
                sum += seconds[task];
                largest = std::max(largest, bytes[plan.task(task).job]);
            }
            batch.limits = limits_of(sum, largest);
            batches.push_back(std::move(batch));
        }
    return batches;
}

JobLimits join_limits(const FarmPlan& plan, const std::vector<TaskStatus>& states) {
    double largest = 0;
    for (const PlanJob& job : plan.jobs) largest = std::max(largest, job.part_bytes);
    for (const double bytes : job_bytes(plan, states)) largest = std::max(largest, bytes);
    return limits_of(plan.join_seconds, largest);
}

}  // namespace haarfield
