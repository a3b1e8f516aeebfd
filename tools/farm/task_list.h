#pragma once
/// Lists of tasks as text, such as `0-9,12`.

#include "fields/base/result.h"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// True if the text is a list: numbers and ranges FIRST-LAST, separated by commas.
bool is_task_list(std::string_view text);

/// Returns the tasks of a list in ascending order without duplicates.
///
/// count   number of tasks of the plan.
/// errors  (with an empty `where`) not a list; a range that ends before it starts; a task outside the plan.
Result<std::vector<std::size_t>> listed_tasks(std::string_view text, std::size_t count);

/// Returns the shortest list of tasks in ascending order.
std::string task_list(std::span<const std::size_t> tasks);

}  // namespace haarfield
