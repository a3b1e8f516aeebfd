#pragma once
/// Lists of tasks as text: `0-9,12`.

#include "fields/base/result.h"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// True if the text is a list: numbers and ranges FIRST-LAST, separated by commas.
bool is_task_list(std::string_view text);

/// The tasks of a list, ascending, each once.
///
/// count   tasks of the plan.
/// errors  (with an empty `where`) no list; a range that ends before it starts; a task that the plan lacks.
Result<std::vector<std::size_t>> listed_tasks(std::string_view text, std::size_t count);

/// The shortest list of the tasks, which are ascending.
std::string task_list(std::span<const std::size_t> tasks);

}  // namespace haarfield
