#pragma once
/// A process that reads many files with a reader task, for haarfield_fuzz.
///
/// A reader process (fields/file/reader_process.h) starts a sandboxed worker per file, which takes longer
/// than reading a small file. This one reads file after file without a sandbox, until a file crashes it.

#include <filesystem>
#include <string_view>

#include "fields/file/reader_process.h"

namespace haarfield {

class BatchReader {
public:
    /// Forks a process that restarts the reader after each crash. No other thread may be running.
    explicit BatchReader(const ReaderTask& task);
    ~BatchReader();
    BatchReader(const BatchReader&) = delete;
    BatchReader& operator=(const BatchReader&) = delete;

    /// Reads a file like read_apart.
    ///
    /// errors  those of the task; "its reader ended" for a crash, and for more than 5 s or 64 MiB, which
    ///         limits the time for buffers of the sizes that damaged files state.
    Result<MappedFile> read(const std::filesystem::path& file, std::string_view details);

private:
    struct Shared;
    Shared* shared_;
    int requests_ = -1, answers_ = -1;  ///< Ends of pipes.
};

}  // namespace haarfield
