#pragma once
/// Runs the jobs of a plan in parts, and joins them.

#include "scenes/scene_entities.h"
#include "tools/command.h"
#include "tools/farm/farm_plan.h"
#include "tools/farm/task_part.h"
#include "tools/scene_options.h"

namespace haarfield {

/// The options that all commands of a plan share.
struct JobOptions {
    SceneOptions scene;
    RenderChoices render;
    std::string output;
};

/// Returns the shared options of a command line; ignores all others.
///
/// errors  CLI11's messages.
Result<JobOptions> job_options(const std::vector<std::string>& arguments);

/// Checks that a command accepts its arguments.
///
/// errors  CLI11's messages; a command that plans do not support.
Result<Done> check_arguments(const std::vector<std::string>& arguments);

/// Changes to the folder in which the plan was made, and selects its vector instructions.
///
/// errors  the folder does not exist; this machine lacks the instructions.
Result<Done> enter_plan(const FarmPlan& plan);

/// Consecutive tasks of one job that run together.
struct PlanTasks {
    std::size_t job = 0, part = 0, count = 1;
};

/// The results of tasks, by part.
using PartSections = std::vector<std::vector<Section>>;

/// Runs tasks of one job, which start and prepare the scene once. Missing or damaged results of an earlier
/// stage are recomputed.
///
/// tasks   a single task if the job is undivided or of bounces.
/// folder  the plan's folder.
/// errors  those of the command.
Result<PartSections> done_tasks(const FarmPlan& plan, const PlanTasks& tasks,
                                const std::filesystem::path& folder, CommandContext& context);

/// Joins the parts of a job.
///
/// folder  the plan's folder.
/// errors  those of the command; a missing or damaged part.
Result<Done> join_job(const FarmPlan& plan, std::size_t job, const std::filesystem::path& folder,
                      CommandContext& context);

}  // namespace haarfield
