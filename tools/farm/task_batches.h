#pragma once
/// Tasks gathered into the jobs of a scheduler.

#include "tools/farm/farm_status.h"

namespace haarfield {

/// Limits that a scheduler enforces: estimates, times a margin.
struct JobLimits {
    int minutes = 0, megabytes = 0;
};

/// The tasks of one job of a scheduler.
struct TaskBatch {
    std::size_t stage = 0;  ///< From 0.
    std::vector<std::size_t> tasks;
    JobLimits limits;
};

/// Divides the tasks that are neither done nor running into batches, stage by stage. Each is of one stage.
///
/// least    tasks in a batch, unless fewer are left; more if there would be too many batches.
/// most     batches.
/// returns  the batches. Their limits follow finished tasks of the same job, or the plan's estimates.
/// errors   (with an empty `where`) fewer batches than stages with tasks.
Result<std::vector<TaskBatch>> task_batches(const FarmPlan& plan, const std::vector<TaskStatus>& states,
                                            std::size_t least, std::size_t most);

/// The limits of the job that joins the results.
JobLimits join_limits(const FarmPlan& plan, const std::vector<TaskStatus>& states);

}  // namespace haarfield
