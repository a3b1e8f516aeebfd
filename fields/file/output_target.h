#pragma once
/// Finds where an output goes: a file, a device or a pipe.

#include "fields/base/result.h"

#include <filesystem>
#include <string_view>

namespace haarfield {

/// The file or stream that the name of an output refers to.
struct OutputTarget {
    std::filesystem::path file;  ///< Without symbolic links, unless `is_stream`.
    /// A device, a pipe or this process's stdout or stderr, which is written in place.
    bool is_stream = false;
};

/// Resolves symbolic links, even if the target does not exist yet.
///
/// errors  a directory; too many links.
Result<OutputTarget> output_target(const std::filesystem::path& file);

/// Writes bytes to a device, a pipe, stdout or stderr. Opening a named pipe waits for its reader.
///
/// errors  those of the system (no reader, no space ...).
Result<Done> write_stream(const OutputTarget& stream, std::string_view bytes);

/// Moves a finished file to an output: renames it, or copies its bytes to a stream.
///
/// made    in the directory of `target` unless that is a stream; removed afterwards.
/// errors  those of the system.
Result<Done> move_output(const std::filesystem::path& made, const OutputTarget& target);

}  // namespace haarfield
