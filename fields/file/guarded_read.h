#pragma once
/// Reads an untrusted file with the reader of its format: in a reader process, or in this process if
/// allow_unsandboxed_readers() was called and there is none.

#include "fields/file/reader_process.h"

namespace haarfield {

/// Returns the output of a task for an open file.
///
/// descriptor       a regular file, read from its beginning. Stays open.
/// memory_per_byte  see reader_limits.
/// where            the name of the file in errors.
/// returns          the output of the task, which is untrusted.
/// errors           those of the task, of reads_apart and of read_apart.
Result<MappedFile> guarded_read(const ReaderTask& task, int descriptor, std::string_view details,
                                double memory_per_byte, const std::string& where);

}  // namespace haarfield
