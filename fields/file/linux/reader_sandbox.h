#pragma once
/// Restrictions that a worker of a reader process puts on itself before it reads. Not for users.

#include "fields/file/reader_process.h"

#include <string>

namespace haarfield {

/// Limits memory, the size of the answer, processor time and the number of open files of this process.
/// Disables core dumps.
void limit_this_process(const ReaderLimits& limits);

/// Puts this process into a sandbox, for good. It can then use memory, files that are open already, and
/// threads. Files can be opened only for reading and only below `folder` (Landlock, if the kernel has it).
/// An allow-list of system calls (seccomp) answers EPERM to every other call. It ends the process on calls
/// that trace, start or signal other processes.
///
/// folder   empty: no file can be opened.
/// returns  true if the sandbox is in place.
bool sandbox_this_process(const std::string& folder);

}  // namespace haarfield
