#pragma once
/// Estimates of what jobs take, before any is done: right to a factor of some two, which `status` mends.

#include "scenes/scene.h"
#include "tools/farm/farm_plan.h"

namespace haarfield {

/// The cost of a job.
struct JobCost {
    double setup = 0;  ///< Of each task, before its part. [s of one core]
    double work = 0;   ///< Of all parts together. [s of one core]
    double bytes = 0;  ///< Memory of a task.
};

/// Of the field of an instance's entity.
JobCost field_cost(const Scene& scene, std::size_t instance);

/// Of a command with these arguments.
JobCost command_cost(const Scene& scene, const std::vector<std::string>& arguments);

/// Of what bounces in a bake, where its direct light is there.
JobCost bounces_cost(const Scene& scene);

/// Joining the results of a command.
JobCost join_cost(const Scene& scene, const std::vector<std::string>& arguments);

/// Whether an option is there with this value.
bool has_value(const std::vector<std::string>& arguments, std::string_view name, std::string_view value);

/// The number after an option's name; `otherwise` if it is not there.
double option_number(const std::vector<std::string>& arguments, std::string_view name, double otherwise);

/// Whether an option is there.
bool has_option(const std::vector<std::string>& arguments, std::string_view name);

}  // namespace haarfield
