#pragma once
/// What Linux reports about a process. Internal.

#include <sys/types.h>

#include <string>
#include <vector>

namespace haarfield {

/// Returns the words of /proc/PROCESS/stat behind the process's name: word k is field k + 3 of proc(5). None
/// if the process does not exist.
std::vector<std::string> process_status(pid_t process);

}  // namespace haarfield
