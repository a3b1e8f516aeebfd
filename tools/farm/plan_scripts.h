#pragma once
/// Scripts that hand a plan to a scheduler.

#include "tools/farm/farm_plan.h"

namespace haarfield {

/// How scripts find the program and the plan: absolute paths.
struct ScriptPaths {
    std::string program, plan;
};

/// job.sh: a job of the other two scripts. It runs the hook, then tasks or the join.
///
/// hook         a shell line; it may set `run` to a command that runs the program, such as that of a
///              container.
/// unsandboxed  passes --unsandboxed to the program.
std::string job_script(const FarmPlan& plan, const ScriptPaths& paths, const std::string& hook,
                       bool unsandboxed);

/// slurm.sh: submits the tasks without a good result as array jobs, each stage after the one before has ended
/// well, and the join after the last. Prints the job number of the join. Submits nothing, or takes back what
/// it has submitted, if sbatch refuses a job.
std::string slurm_script(const FarmPlan& plan, const ScriptPaths& paths);

/// parallel.sh: runs the tasks without a good result with GNU parallel, stage by stage, and the join.
std::string parallel_script(const FarmPlan& plan, const ScriptPaths& paths);

}  // namespace haarfield
