#pragma once
/// Restrictions that a worker of a reader process imposes on itself before it reads. Internal.

#include "fields/file/reader_process.h"

#include <string>

namespace haarfield {

/// Limits memory, the size of the answer, processor time and the number of open files of this process.
/// Disables core dumps.
void limit_this_process(const ReaderLimits& limits);

/// Sandboxes this process permanently. It can then use memory, open files and threads. It can open files only
/// for reading and only below `folder` (Landlock, if the kernel has it). An allow-list of system calls
/// (seccomp) rejects every other call with EPERM. Calls that trace, start or signal other processes kill the
/// process.
///
/// folder   empty: no file can be opened.
/// returns  true if the sandbox is in place.
bool sandbox_this_process(const std::string& folder);

}  // namespace haarfield
