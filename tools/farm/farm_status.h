#pragma once
/// How far a plan is, and how long it would take on how many nodes.

#include "tools/farm/task_part.h"

#include <optional>

namespace haarfield {

enum class TaskState { waiting, running, done, failed };

/// What is known of a task.
struct TaskStatus {
    TaskState state = TaskState::waiting;
    TaskCost cost;        ///< Of one that is done.
    std::string failure;  ///< Of one that failed.
};

/// Of all tasks. One whose claim a living process of this machine has, or was renewed within the last
/// minute, is running; by this machine's clock.
std::vector<TaskStatus> task_states(const std::filesystem::path& folder, const FarmPlan& plan);

/// Which time a task took: that of the clock; or the processor's, shared by the plan's threads, as if its
/// node had done nothing else.
enum class TaskTime { clock, processor };

/// Seconds of each task: what those took that are done; of others what was estimated, times how far off
/// estimates of their kind of job were. [s]
std::vector<double> task_seconds(const FarmPlan& plan, const std::vector<TaskStatus>& states,
                                 TaskTime time = TaskTime::clock);

/// When all would be done that is not: tasks of a stage are started in their order, each as soon as a node
/// is free and the stage before is done. A node does one task at a time; each costs `overhead` more for the
/// scheduler. [s]
double simulated_seconds(const FarmPlan& plan, const std::vector<double>& seconds,
                         const std::vector<bool>& left, std::size_t nodes, double overhead);

}  // namespace haarfield
