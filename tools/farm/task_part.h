#pragma once
/// Stores results of tasks in a plan's folder.

#include "fields/file/section_file.h"
#include "tools/farm/farm_plan.h"

#include <optional>

namespace haarfield {

/// The cost of a task.
struct TaskCost {
    /// Wall time; processor time of all threads and child processes. [s]
    double seconds = 0, cpu_seconds = 0;
    std::uint64_t peak_bytes = 0;  ///< Peak memory of the process.
    std::string host;
};

/// A task's result.
struct TaskPart {
    TaskCost cost;
    std::vector<Section> sections;
};

/// Writes a task's result atomically.
Result<Done> write_part(const std::filesystem::path& folder, const FarmPlan& plan, std::size_t task,
                        const TaskPart& part);

/// Reads a task's result.
///
/// errors  the file does not exist, is damaged, or belongs to another plan or task.
Result<TaskPart> read_part(const std::filesystem::path& folder, const FarmPlan& plan, std::size_t task);

/// Returns the cost of a task if its result has the right length. Does not verify the checksum.
std::optional<TaskCost> part_cost(const std::filesystem::path& folder, const FarmPlan& plan,
                                  std::size_t task);

/// Returns the processor time and peak memory of this process and its child processes.
///
/// seconds  wall time.
TaskCost process_cost(double seconds);

/// Returns the files below a folder as sections `file NAME`.
Result<std::vector<Section>> file_sections(const std::filesystem::path& folder);

/// Writes the sections of file_sections below another folder; skips other sections.
///
/// errors  I/O errors; a name that leads outside of the folder.
Result<Done> write_file_sections(const std::vector<Section>& sections, const std::filesystem::path& folder);

}  // namespace haarfield
