#pragma once
/// Reads untrusted files in a separate, sandboxed process.
///
/// A reader process waits for files. For each file it forks a worker. The worker reads the file with the
/// library for its format, within limits, writes the content as bytes, and ends. A crash, a hang or excessive
/// use of memory becomes an Error in this process.
///
/// Programs start the executable `haarfield-reader` when they read the first file. It is searched for next to
/// the running executable, next to the shared library that holds this code, and where it was installed. The
/// environment variable HAARFIELD_READER overrides this search: it names the executable or, if it is empty,
/// disables reader processes. Tests fork their reader process (fork_reader_process).
///
/// A worker can read the given file and files in the folder that its task needs. It has no network, cannot
/// write files, and cannot start, trace or signal processes (seccomp, and Landlock if the kernel has it).
///
/// Without a reader process, or on a system without seccomp, files that assimp or OpenImageIO would read are
/// refused. A program that trusts its files calls allow_unsandboxed_readers().

#include "fields/base/byte_stream.h"
#include "fields/base/result.h"
#include "fields/file/mapped_file.h"

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace haarfield {

/// The resources that a worker may use.
struct ReaderLimits {
    std::uint64_t memory = 0;  ///< [bytes] Worker and answer together, not counting the reader process.
    std::uint64_t answer = 0;  ///< [bytes] The part of `memory` that is reserved for the answer.
    double seconds = 0;        ///< Processor time, independent of the load of the machine.
};

/// Returns the limits for a file of `file_bytes`: 1 GiB plus `memory_per_byte` times its size, but at most
/// the memory of the machine, one half of it for the answer; 10 s plus 1 s per MB.
ReaderLimits reader_limits(std::uint64_t file_bytes, double memory_per_byte);

/// A kind of file and its reader.
struct ReaderTask {
    std::string_view name;
    /// Reads a file from its bytes. `details` is the text that the client passed.
    Result<Done> (*read)(std::string_view bytes, std::string_view details, ByteSink& answer);
    /// Returns the folder in which `read` opens further files. Null: `read` opens no files.
    std::string (*folder)(std::string_view details) = nullptr;
    /// The loading of the file. Tasks that may read a small part of it use MappedPages::as_read.
    MappedPages pages = MappedPages::now;
};

/// Forks the reader process of this process, which takes some milliseconds. Call it once, at the start of
/// `main`, before the program starts threads. A fork would copy locks that other threads hold. Therefore,
/// this function waits until all threads that libraries started on loading are asleep.
///
/// Does nothing if HAARFIELD_READER is set.
///
/// errors  other threads are running; those of the system.
Result<Done> fork_reader_process(std::span<const ReaderTask> tasks);

/// Runs `haarfield-reader`: serves requests on an inherited socket until its other end is closed.
[[noreturn]] void serve_reader_process(int socket, std::span<const ReaderTask> tasks);

/// Lets this process read untrusted files without a sandbox from now on if there is no reader process or the
/// system has no seccomp. A malicious file can then do what this process can. Call it before the first file
/// is read.
void allow_unsandboxed_readers();

/// The remedy in errors about untrusted files that cannot be read in a sandbox.
inline constexpr const char* unsandboxed_remedy =
    "to read it without a sandbox, if you trust it, use the option --unsandboxed (in C++ "
    "allow_unsandboxed_readers(), in Python haarfield.allow_unsandboxed_readers())";

/// Returns true if a reader process reads untrusted files, and false if this process may read them itself.
/// Starts the reader process if necessary.
///
/// errors  there is no reader process, and allow_unsandboxed_readers() was not called; HAARFIELD_READER names
///         a program that cannot be run.
Result<bool> reads_apart();

/// Reads a file in a worker. Requires reads_apart(). Thread-safe.
///
/// descriptor  a regular file or a file in memory, read from its beginning. Stays open.
/// where       the name of the file in errors.
/// returns     the output of the task. It is untrusted, because a malicious file may have compromised the
///             worker.
/// errors      those of the task; it crashed or exceeded its limits.
Result<MappedFile> read_apart(std::string_view task, int descriptor, std::string_view details,
                              const ReaderLimits& limits, const std::string& where);

/// Reads bytes in memory like a file.
Result<MappedFile> read_apart(std::string_view task, std::string_view bytes, std::string_view details,
                              const ReaderLimits& limits, const std::string& where);

}  // namespace haarfield
