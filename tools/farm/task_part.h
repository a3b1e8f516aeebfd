#pragma once
/// Results of tasks in a plan's folder.

#include "fields/file/section_file.h"
#include "tools/farm/farm_plan.h"

#include <optional>

namespace haarfield {

/// What a task took.
struct TaskCost {
    double seconds = 0, cpu_seconds = 0;  ///< Of the clock; of all threads and of programs that it ran. [s]
    std::uint64_t peak_bytes = 0;         ///< The most memory that the process had.
    std::string host;
};

/// A task's result.
struct TaskPart {
    TaskCost cost;
    std::vector<Section> sections;
};

/// Publishes a task's result, whole.
Result<Done> write_part(const std::filesystem::path& folder, const FarmPlan& plan, std::size_t task,
                        const TaskPart& part);

/// Reads it.
///
/// errors  there is none; it is damaged, or of another plan or task.
Result<TaskPart> read_part(const std::filesystem::path& folder, const FarmPlan& plan, std::size_t task);

/// What it took, if there is one of the right length; its checksum is not read.
std::optional<TaskCost> part_cost(const std::filesystem::path& folder, const FarmPlan& plan,
                                  std::size_t task);

/// The processor's time and the most memory that this process has used, with programs that it ran.
///
/// seconds  of the clock.
TaskCost process_cost(double seconds);

/// The files below a folder as sections `file NAME`.
Result<std::vector<Section>> file_sections(const std::filesystem::path& folder);

/// The inverse: writes them below another folder. Other sections are left out.
///
/// errors  what the system says; a name that leads elsewhere.
Result<Done> write_file_sections(const std::vector<Section>& sections, const std::filesystem::path& folder);

}  // namespace haarfield
