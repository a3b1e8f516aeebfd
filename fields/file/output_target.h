#pragma once
/// Finds where an output goes: a file, a device or a pipe.

#include "fields/base/result.h"

#include <filesystem>
#include <string_view>

namespace haarfield {

/// The place that the name of an output stands for.
struct OutputTarget {
    std::filesystem::path file;  ///< Without symbolic links, unless `is_stream`.
    bool is_stream = false;      ///< A device, a pipe or this process's stdout or stderr: written in place.
};

/// Follows symbolic links, also to files that do not exist yet.
///
/// errors  a directory; too many links.
Result<OutputTarget> output_target(const std::filesystem::path& file);

/// Writes bytes to a device, a pipe, stdout or stderr. Opening a named pipe waits for its reader.
///
/// errors  those of the system (no reader, no space ...).
Result<Done> write_stream(const OutputTarget& stream, std::string_view bytes);

/// Moves a finished file to where an output goes: renames it, or copies its bytes into a stream.
///
/// made    in the directory of `target` if `target` is no stream; gone afterwards.
/// errors  those of the system.
Result<Done> move_output(const std::filesystem::path& made, const OutputTarget& target);

}  // namespace haarfield
