#pragma once
/// Files of others, read by a process of its own: what takes their reader down takes nothing else down.
///
/// A reader process waits for files. For each it forks a worker, which reads the file with the library that
/// knows its format, within limits, writes what it found as bytes, and ends. A crash there, a hang or a
/// hunger for memory is an Error here.
///
/// The program has its reader process from its start (fork_reader_process). Any other user of the library
/// gets one by the executable `haarfield-reader` when the first file is read, if that is found: beside the
/// running executable, or where it was installed. Where there is none files are read in the process itself,
/// with no protection against what their readers do. The environment's HAARFIELD_READER has the last word, in
/// the program, too: it names the executable or, where it is empty, says that there is to be none.
///
/// A worker can open files for reading only, has no network and starts no program, where the system lets it
/// be filtered (seccomp, on x86-64 and 64 bit ARM); its limits hold everywhere.

#include "fields/base/byte_stream.h"
#include "fields/base/result.h"
#include "fields/file/mapped_file.h"

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace haarfield {

/// What a worker may use.
struct ReaderLimits {
    std::uint64_t memory = 0;  ///< [bytes], beyond what the reader process itself has.
    double seconds = 0;        ///< Of the processor; of the clock on the wall, three times as many.
};

/// For a file of so many bytes: 1 GiB and `memory_per_byte` times its size, but no more than the machine has;
/// 10 s and 1 s a MB.
ReaderLimits reader_limits(std::uint64_t file_bytes, double memory_per_byte);

/// A kind of files, and who reads them.
struct ReaderTask {
    std::string_view name;
    /// Reads a file of which the bytes are given. `details` is what the asker said of it.
    Result<Done> (*read)(std::string_view bytes, std::string_view details, ByteSink& answer);
};

/// Forks this process's reader, within some milliseconds. Once, from the beginning of `main`, before there
/// are threads but those that libraries have from their loading on: a fork would leave locks behind that
/// others hold, so that it waits for these to sleep.
///
/// Does nothing where HAARFIELD_READER is set.
///
/// errors  other threads are at work; what the system says.
Result<Done> fork_reader_process(std::span<const ReaderTask> tasks);

/// What `haarfield-reader` does: waits for files on a socket that it has inherited, until its other end is
/// closed.
[[noreturn]] void serve_reader_process(int socket, std::span<const ReaderTask> tasks);

/// Whether files of others are read by another process. Looks for one if none was asked for yet.
///
/// errors  what HAARFIELD_READER names can not be run.
Result<bool> reads_apart();

/// Has a file read. Only where reads_apart(). From any thread.
///
/// descriptor  of the file, a regular one or one in memory; read from its beginning. Stays open.
/// where       what errors call it.
/// returns     what the task wrote: not to be believed, as the file's author may have had his way with it.
/// errors      the task's; that it crashed, or took more than its limits.
Result<MappedFile> read_apart(std::string_view task, int descriptor, std::string_view details,
                              const ReaderLimits& limits, const std::string& where);

/// The same of bytes in memory.
Result<MappedFile> read_apart(std::string_view task, std::string_view bytes, std::string_view details,
                              const ReaderLimits& limits, const std::string& where);

}  // namespace haarfield
