#pragma once
/// Estimates the cost of jobs within a factor of about two. `status` corrects the estimates by finished
/// tasks.

#include "scenes/scene.h"
#include "tools/farm/farm_plan.h"

namespace haarfield {

/// The cost of a job.
struct JobCost {
    double setup = 0;  ///< Per task, before its part. [s of one core]
    double work = 0;   ///< Of all parts together. [s of one core]
    double bytes = 0;  ///< Memory of a task.
};

/// Returns the cost of the field of an instance's entity.
JobCost field_cost(const Scene& scene, std::size_t instance);

/// Returns the cost of a command with these arguments. Bakes of Division::direct: that of their direct light.
JobCost command_cost(const Scene& scene, const std::vector<std::string>& arguments);

/// Returns the cost of the remainder of a bake, given its direct light.
JobCost remainder_cost(const Scene& scene, const std::vector<std::string>& arguments);

/// Returns the cost of joining a command's results.
JobCost join_cost(const Scene& scene, const std::vector<std::string>& arguments);

/// True if an option has this value.
bool has_value(const std::vector<std::string>& arguments, std::string_view name, std::string_view value);

/// Returns the number after an option's name, or `otherwise` if the option is absent.
double option_number(const std::vector<std::string>& arguments, std::string_view name, double otherwise);

/// True if an option is present.
bool has_option(const std::vector<std::string>& arguments, std::string_view name);

}  // namespace haarfield
