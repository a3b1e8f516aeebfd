#pragma once
/// Processor time of child processes.

#include <sys/types.h>

#include <optional>

namespace haarfield {

/// Returns the processor time that a running process and its descendants have used. [s] None if the system
/// does not report it.
///
/// accuracy  10 ms. Descendants whose parents ended before them are not counted.
/// cost      10 us for each process of the system.
std::optional<double> processor_seconds(pid_t process);

}  // namespace haarfield
