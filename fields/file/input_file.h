#pragma once
/// Opens files for reading. Only regular files are accepted: reading a pipe or a device may block forever.

#include "fields/base/result.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace haarfield {

/// A regular file, open for reading.
class InputFile {
public:
    /// Opens a file. Never waits for the writer of a pipe.
    ///
    /// errors  no such file; a directory, a pipe, a device or a socket; those of the system.
    static Result<InputFile> open(const std::filesystem::path& file);

    /// Takes ownership of the file.
    InputFile(InputFile&& other) noexcept : descriptor_(other.descriptor_) { other.descriptor_ = -1; }
    InputFile& operator=(InputFile&&) = delete;
    ~InputFile();

    int descriptor() const { return descriptor_; }  ///< Closed by the destructor.

private:
    explicit InputFile(int descriptor) : descriptor_(descriptor) {}

    int descriptor_;
};

/// Tests whether a path names a regular file, without opening it.
///
/// expected  what the file should hold, for the message: "a mesh"
/// errors    those of InputFile::open that do not depend on the right to read
Result<Done> check_input_file(const std::filesystem::path& file, const std::string& expected = "a file");

/// Reads a file of unknown size, such as those below /proc.
///
/// most_bytes  a multiple of 1 MiB
/// errors      those of InputFile::open; more than most_bytes.
Result<std::string> read_whole_file(const std::filesystem::path& file, std::uint64_t most_bytes);

}  // namespace haarfield
