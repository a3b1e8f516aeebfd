#pragma once
/// The progress of a plan, and its estimated time on a number of nodes.

#include "fields/base/progress.h"
#include "tools/farm/task_part.h"

#include <optional>

namespace haarfield {

enum class TaskState { waiting, running, done, failed, damaged };

/// The status of a task.
struct TaskStatus {
    TaskState state = TaskState::waiting;
    TaskCost cost;        ///< Of a finished task.
    std::string failure;  ///< The message of a failed task.
};

/// The depth of a verification of results.
enum class ResultCheck {
    length,  ///< By their lengths: reads a page or two of each file.
    content  ///< By their checksums: reads all files.
};

/// Returns the states of all tasks. A task is running if its claim belongs to a living process of this
/// machine, or was renewed within the last minute by this machine's clock. A task whose result fails the
/// check is damaged.
///
/// returns  the states. If a stop is requested, unchecked tasks are `waiting`.
std::vector<TaskStatus> task_states(const std::filesystem::path& folder, const FarmPlan& plan,
                                    ResultCheck check = ResultCheck::length, const Progress& progress = {});

/// The time of a task: wall time; or processor time divided by the plan's threads, as if its node had run
/// nothing else.
enum class TaskTime { clock, processor };

/// Returns the time of each task. Finished tasks have their measured time. The estimates of other tasks are
/// scaled by measured over estimated time of the finished tasks with the same division. [s]
std::vector<double> task_seconds(const FarmPlan& plan, const std::vector<TaskStatus>& states,
                                 TaskTime time = TaskTime::clock);

/// Returns the simulated time until all tasks in `left` are done. Tasks of a stage start in order, each as
/// soon as a node is free and the previous stage is done. A node runs one task at a time. Each task takes
/// `overhead` more for the scheduler. [s]
double simulated_seconds(const FarmPlan& plan, const std::vector<double>& seconds,
                         const std::vector<bool>& left, std::size_t nodes, double overhead);

}  // namespace haarfield
