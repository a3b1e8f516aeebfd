#pragma once
/// Kinds of haarfield_fuzz that are field files.
///
/// OpenVDB parses them and trusts its input, so that damaged files crash it.

#include <memory>

#include "tests/fuzz/subject.h"

namespace haarfield {

/// Lets a BatchReader parse field files, which is faster than the reader process of the program. Call it
/// before this process starts threads.
void read_fields_in_batches();

/// Damaged field files: rejected, or read as one of the fields that were written.
std::unique_ptr<Subject> damaged_fields();

/// Field files with correct hashes whose values, topology, metadata or list of grids changed: rejected, or
/// safe to use.
std::unique_ptr<Subject> forged_fields();

}  // namespace haarfield
