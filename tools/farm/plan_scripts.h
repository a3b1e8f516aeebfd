#pragma once
/// Scripts that hand a plan to a scheduler.

#include "tools/farm/farm_plan.h"

namespace haarfield {

/// How scripts find the program and the plan: absolute paths.
struct ScriptPaths {
    std::string program, plan;
};

/// `sh slurm.sh [options of sbatch]` submits the stages as array jobs of at most 1,000 tasks, each stage
/// after the one before has ended well, and the join after the last; it prints the join's job number.
std::string slurm_script(const FarmPlan& plan, const ScriptPaths& paths);

/// `sh parallel.sh [options of parallel]`: a line of GNU parallel a stage, which may be run again after
/// failures, and the join.
std::string parallel_script(const FarmPlan& plan, const ScriptPaths& paths);

}  // namespace haarfield
