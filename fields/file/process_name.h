#pragma once
/// Names of processes, in files that several machines share.

#include <string>
#include <string_view>

namespace haarfield {

/// Returns the name of this process, which no other process has: `PLACE-PID-START`. PLACE is twelve
/// hexadecimal digits that identify the machine since its last boot and its process number space. PID is the
/// process number and START the start time.
std::string process_name();

/// The state of a process.
enum class Liveness {
    alive,
    ended,
    unknown,  ///< It runs on another machine, or the name is invalid.
};

/// Tests whether the process of that name is still running.
Liveness process_liveness(std::string_view name);

}  // namespace haarfield
