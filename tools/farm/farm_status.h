#pragma once
/// How far a plan is, and how long it would take on how many nodes.

#include "fields/base/progress.h"
#include "tools/farm/task_part.h"

#include <optional>

namespace haarfield {

enum class TaskState { waiting, running, done, failed, damaged };

/// What is known of a task.
struct TaskStatus {
    TaskState state = TaskState::waiting;
    TaskCost cost;        ///< Of one that is done.
    std::string failure;  ///< Of one that failed.
};

/// How results are checked.
enum class ResultCheck {
    length,  ///< By their length: a page or two of each file is read.
    content  ///< By their checksums: all files are read.
};

/// The states of all tasks. A task is running if its claim belongs to a living process of this machine or was
/// renewed within the last minute, by this machine's clock. A task with a result that fails the check is
/// damaged.
///
/// returns  the states; those not reached yet are `waiting` if a stop is requested.
std::vector<TaskStatus> task_states(const std::filesystem::path& folder, const FarmPlan& plan,
                                    ResultCheck check = ResultCheck::length, const Progress& progress = {});

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
