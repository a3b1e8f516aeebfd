#pragma once
/// Groups tasks into the jobs of a scheduler.

#include "tools/farm/farm_status.h"

namespace haarfield {

/// Limits that a scheduler enforces: estimates times a margin.
struct JobLimits {
    int minutes = 0, megabytes = 0;
};

/// The tasks of one scheduler job.
struct TaskBatch {
    std::size_t stage = 0;  ///< Counted from 0.
    std::vector<std::size_t> tasks;
    JobLimits limits;
};

/// Divides the tasks that are neither done nor running into batches. Each batch belongs to one stage.
///
/// least    tasks per batch, unless fewer remain. More if there would be too many batches.
/// most     maximum number of batches.
/// returns  the batches. Their limits follow finished tasks of the same job, or the plan's estimates.
/// errors   (with an empty `where`) fewer batches than stages with tasks.
Result<std::vector<TaskBatch>> task_batches(const FarmPlan& plan, const std::vector<TaskStatus>& states,
                                            std::size_t least, std::size_t most);

/// Returns the limits of the job that joins the results.
JobLimits join_limits(const FarmPlan& plan, const std::vector<TaskStatus>& states);

}  // namespace haarfield
