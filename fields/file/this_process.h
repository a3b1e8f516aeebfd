#pragma once
/// The running process, as far as each system describes it differently.

#include <filesystem>

namespace haarfield {

/// Returns the path of the running executable, or `haarfield` on systems that do not report it.
std::filesystem::path running_program();

/// Asks the system to end this process when its parent ends, on systems that can. Safe between fork and exec.
void end_with_parent();

}  // namespace haarfield
