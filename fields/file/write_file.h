#pragma once
/// Writing of complete files, and creation of folders.

#include "fields/base/result.h"

#include <filesystem>
#include <string_view>

namespace haarfield {

/// Writes bytes to a file, a device or a pipe. A file appears complete or not at all (TemporaryFile).
/// Symbolic links are followed. Does not wait until the bytes are on disk.
///
/// errors  those of the system (no such folder, full disk ...); a directory has this name.
Result<Done> write_file(const std::filesystem::path& file, std::string_view bytes);

/// Creates a folder, with its parents, unless it exists. Removes files in it that were left by processes that
/// have ended (remove_abandoned_files).
///
/// errors  those of the system; a file has this name.
Result<Done> make_folder(const std::filesystem::path& folder);

}  // namespace haarfield
