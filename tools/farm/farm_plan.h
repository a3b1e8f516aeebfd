#pragma once
/// Work divided into tasks for a scheduler: what `plan` writes and `work`, `join` and `status` read.
///
/// A plan is a folder:
///
///     plan.json           the plan, never changed once it is there
///     slurm.sh            submits the tasks without a good result to Slurm
///     parallel.sh         runs them with GNU parallel
///     job.sh              the job of either script: loads modules or enters a container, and runs tasks
///     logs/, submitted/   logs of jobs; the tasks of each submission
///     parts/K.part        the result of task K (task_part.h)
///     parts/K.claim       a process is at task K (claim.h)
///     parts/K.failed      why task K failed last
///     fields/, results/   what joins make, if they are not wanted elsewhere

#include "fields/base/result.h"

#include <nlohmann/json.hpp>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haarfield {

/// How a job is divided.
enum class Division {
    samples,   ///< A field, by its samples.
    shading,   ///< A bake without bounces, by its points.
    strips,    ///< A reference, by its two sets of lights and strips of rows.
    frames,    ///< A relight, by its frames.
    direct,    ///< The direct light of a bake with bounces, by its points.
    bounces,   ///< All else of that bake: one task.
    undivided  ///< One task does all.
};

/// How a command line can be divided; none if plans do not have its command. One whose direct light can be
/// divided is a job of that and one of bounces; or it is undivided.
std::optional<Division> possible_division(const std::vector<std::string>& arguments);

/// Whether a command line can have a job so divided.
bool can_have(const std::vector<std::string>& arguments, Division division);

/// That a plan can have: `status` looks at each within some microseconds, and keeps some 100 bytes of it.
inline constexpr std::size_t most_plan_tasks = 1000000;

/// A file that a job reads.
struct PlanInput {
    std::string file, hash;  ///< XXH3-128, in hexadecimal digits.
};

/// A command that is to be run.
struct PlanJob {
    std::vector<std::string> arguments;  ///< As typed after `haarfield`; paths are absolute.
    Division division = Division::undivided;
    std::vector<PlanInput> inputs;
    std::size_t instance = 0;  ///< Of `samples`: one of the scene's, of whose shape the field is.
    std::size_t direct = 0;    ///< Of `bounces`: the number of the job before it that has the direct light.
    std::size_t parts = 1;     ///< 1 if undivided and of bounces; of strips an even number.
    double part_seconds = 0;   ///< Estimated for one part, on the threads of a task. [s]
    double part_bytes = 0;     ///< Estimated memory of a task.

    const std::string& command() const { return arguments.front(); }  ///< `precompute`, `bake` ...
};

/// Which part of which job a task does.
struct PlanTask {
    std::size_t job = 0, part = 0;
};

struct FarmPlan {
    std::string version;       ///< Of haarfield.
    std::string id;            ///< Of this plan, unlike any other's.
    std::string folder;        ///< Where it was made: what relative paths in options are relative to.
    std::string instructions;  ///< instruction_set.h
    int threads = 1;           ///< Of a task.
    double task_seconds = 0;   ///< What was aimed at. [s]
    double join_seconds = 0;   ///< Estimated for the join, on the threads of a task. [s]
    std::vector<PlanJob> jobs;
    /// The first task of each stage, and their number: a stage wants what the one before has made, and makes
    /// it itself where it is missing. Tasks are numbered job by job, part by part.
    std::array<std::size_t, 4> stages{};

    std::size_t task_count() const { return stages.back(); }
    PlanTask task(std::size_t number) const;
    std::size_t first_task(std::size_t job) const;
};

/// The folder's plan.
///
/// errors  what the system says; no plan, or one of another version of haarfield; a value of another kind or
///         beyond its range; a job of no command, or not divided as its command is; no task at all, more than
///         most_plan_tasks, or stages that have others than the jobs.
Result<FarmPlan> read_plan(const std::filesystem::path& folder);

std::string plan_text(const FarmPlan& plan);  ///< As JSON.

/// The XXH3-128 of a file's content, in hexadecimal digits.
Result<std::string> file_hash(const std::filesystem::path& file);

/// Whether a job's inputs are as they were when it was planned.
///
/// errors  what has changed.
Result<Done> check_inputs(const PlanJob& job);

/// Files of a task in the plan's folder, `ending` being `part`, `claim` or `failed`.
std::filesystem::path task_file(const std::filesystem::path& folder, std::size_t task, const char* ending);

}  // namespace haarfield
