#pragma once
/// What a worker of a reader process gives up before it reads. Not for users.

#include "fields/file/reader_process.h"

namespace haarfield {

/// Limits memory, time, the size and number of files of this process, and writes no core.
void limit_this_process(const ReaderLimits& limits);

/// Takes from this process the right to change files, to reach a network and to start programs: what tries
/// that gets an error. Does nothing where the system has no such filter.
///
/// returns  whether the filter is in place.
bool sandbox_this_process();

}  // namespace haarfield
