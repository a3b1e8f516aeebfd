#pragma once
/// Scripts that submit a plan to a scheduler.

#include "tools/farm/farm_plan.h"

namespace haarfield {

/// The absolute paths of the program and the plan.
struct ScriptPaths {
    std::string program, plan;
};

/// Returns job.sh, a job of the other two scripts. It runs the hook, then tasks or the join.
///
/// hook         a shell line that may set `run` to a command that runs the program, such as a container.
/// unsandboxed  true: passes --unsandboxed to the program.
std::string job_script(const FarmPlan& plan, const ScriptPaths& paths, const std::string& hook,
                       bool unsandboxed);

/// Returns slurm.sh, which submits the tasks without a good result as array jobs. Each stage starts after the
/// previous one has succeeded, and the join after the last one. The script prints the job number of the join.
/// If sbatch refuses a job, the script cancels the jobs that it has submitted.
std::string slurm_script(const FarmPlan& plan, const ScriptPaths& paths);

/// Returns parallel.sh, which runs the tasks without a good result with GNU parallel, stage by stage, and
/// then the join.
std::string parallel_script(const FarmPlan& plan, const ScriptPaths& paths);

}  // namespace haarfield
