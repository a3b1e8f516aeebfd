#pragma once
/// The jobs of a plan, done in parts and as wholes.

#include "scenes/scene_entities.h"
#include "tools/command.h"
#include "tools/farm/farm_plan.h"
#include "tools/farm/task_part.h"
#include "tools/scene_options.h"

namespace haarfield {

/// What a plan's commands have in common.
struct JobOptions {
    SceneOptions scene;
    RenderChoices render;
    std::string output;
};

/// The options that a command line has of these; it need be no more than understood.
///
/// errors  what CLI11 says of them.
Result<JobOptions> job_options(const std::vector<std::string>& arguments);

/// Whether the command would take the arguments.
///
/// errors  what CLI11 says of them; a command that no plan has.
Result<Done> check_arguments(const std::vector<std::string>& arguments);

/// Goes to the folder where the plan was made, and chooses its instructions.
///
/// errors  there is no such folder; instructions that this machine has not.
Result<Done> enter_plan(const FarmPlan& plan);

/// Consecutive tasks of one job, run together.
struct PlanTasks {
    std::size_t job = 0, part = 0, count = 1;
};

/// The results of tasks, by part.
using PartSections = std::vector<std::vector<Section>>;

/// Runs tasks of one job, which start and prepare the scene once. A missing or damaged result of an earlier
/// stage is computed again.
///
/// tasks   one of a job that is undivided or of bounces.
/// folder  the plan's.
/// errors  those of the command.
Result<PartSections> done_tasks(const FarmPlan& plan, const PlanTasks& tasks,
                                const std::filesystem::path& folder, CommandContext& context);

/// Puts together what the parts of a job have.
///
/// folder  the plan's.
/// errors  those of the command; a part that is not good.
Result<Done> join_job(const FarmPlan& plan, std::size_t job, const std::filesystem::path& folder,
                      CommandContext& context);

}  // namespace haarfield
