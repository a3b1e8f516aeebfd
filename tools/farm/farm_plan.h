#pragma once
/// Divides work into tasks for a scheduler. `plan` writes plans; `work`, `join` and `status` read them.
///
/// A plan is a folder:
///
///     plan.json           the plan, which never changes
///     slurm.sh            submits the tasks without a good result to Slurm
///     parallel.sh         runs the tasks without a good result with GNU parallel
///     job.sh              a job of either script: loads modules or enters a container, and runs tasks
///     logs/, submitted/   logs of jobs; the tasks of each submission
///
/// Results of tasks and joins:
///
///     parts/K.part        the result of task K (task_part.h)
///     parts/K.claim       exists while a process runs task K (claim.h)
///     parts/K.failed      the reason of the last failure of task K
///
///     fields/, results/   the results of joins, unless other folders are given

#include "fields/base/result.h"

#include <nlohmann/json.hpp>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haarfield {

/// The division of a job into tasks.
enum class Division {
    samples,   ///< A field, by its samples.
    shading,   ///< A bake without bounces, by its points.
    strips,    ///< A reference, by its two sets of lights and strips of rows.
    frames,    ///< A relight, by its frames.
    direct,    ///< The first direct light of a bake with indirect light or with a search, by its points.
    bounces,   ///< The remainder of that bake: one task.
    undivided  ///< One task.
};

/// True if a command line is a bake that searches for an error (target_error).
bool searches(const std::vector<std::string>& arguments);

/// Returns the division of a command line, or none if plans do not support its command. `direct` stands for
/// two jobs, one of direct light and one of bounces; such a command line may also be undivided.
std::optional<Division> possible_division(const std::vector<std::string>& arguments);

/// True if a job with this command line can have this division.
bool can_have(const std::vector<std::string>& arguments, Division division);

/// The most tasks of a plan. `status` spends some microseconds and about 100 bytes on each.
inline constexpr std::size_t most_plan_tasks = 1000000;

/// A file that a job reads.
struct PlanInput {
    std::string file, hash;  ///< XXH3-128, in hexadecimal digits.
};

/// A command of a plan.
struct PlanJob {
    std::vector<std::string> arguments;  ///< The command line after `haarfield`, with absolute paths.
    Division division = Division::undivided;
    std::vector<PlanInput> inputs;
    std::size_t instance = 0;  ///< For `samples`: an instance of the scene whose shape the field has.
    std::size_t direct = 0;    ///< For `bounces`: the index of the earlier job with the direct light.
    std::size_t parts = 1;     ///< 1 for `undivided` and `bounces`; even for `strips`.
    double part_seconds = 0;   ///< Estimated time of one part, on the threads of a task. [s]
    double part_bytes = 0;     ///< Estimated memory of a task. [bytes]

    const std::string& command() const { return arguments.front(); }  ///< `precompute`, `bake` ...
};

/// The job of a task, and the part of the job.
struct PlanTask {
    std::size_t job = 0, part = 0;
};

struct FarmPlan {
    std::string version;       ///< The version of haarfield.
    std::string id;            ///< A unique identifier.
    std::string folder;        ///< The working directory of `plan`, the base of relative paths in options.
    std::string instructions;  ///< instruction_set.h
    int threads = 1;           ///< Threads per task.
    double task_seconds = 0;   ///< The intended time per task. [s]
    double join_seconds = 0;   ///< Estimated time of the join, on the threads of a task. [s]
    std::vector<PlanJob> jobs;
    /// The first task of each stage, then the number of tasks. A stage needs the results of the one before,
    /// and computes missing results itself. Tasks are numbered job by job, part by part.
    std::array<std::size_t, 4> stages{};

    std::size_t task_count() const { return stages.back(); }
    PlanTask task(std::size_t number) const;
    std::size_t first_task(std::size_t job) const;
};

/// Reads the plan of a folder.
///
/// errors  I/O errors; no plan, or one of another version of haarfield; a value of the wrong type or out of
///         range; an unknown command, or a division that does not suit it; no task, more than
///         most_plan_tasks, or stages that do not match the jobs.
Result<FarmPlan> read_plan(const std::filesystem::path& folder);

std::string plan_text(const FarmPlan& plan);  ///< Returns the plan as JSON.

/// Returns the XXH3-128 hash of a file's content, in hexadecimal digits.
Result<std::string> file_hash(const std::filesystem::path& file);

/// Checks that the inputs of a job have not changed since the plan was made.
///
/// errors  names the changed file.
Result<Done> check_inputs(const PlanJob& job);

/// Returns a task's file in the plan's folder. `ending` is `part`, `claim` or `failed`.
std::filesystem::path task_file(const std::filesystem::path& folder, std::size_t task, const char* ending);

}  // namespace haarfield
