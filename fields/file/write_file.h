#pragma once
/// Whole files out, and the folders that they go to.

#include "fields/base/result.h"

#include <filesystem>
#include <string_view>

namespace haarfield {

/// Writes bytes to a file, a device or a pipe. A file appears whole or not at all: it is a TemporaryFile
/// before. Symbolic links are followed. Does not wait until the bytes are on the disk.
///
/// errors  those of the system (no such folder, full disk ...); a directory has the name.
Result<Done> write_file(const std::filesystem::path& file, std::string_view bytes);

/// Makes the folder, with those above it, if it is not there; and removes from it what processes that have
/// ended left half-written (remove_abandoned_files).
///
/// errors  what the system says; a file of that name.
Result<Done> make_folder(const std::filesystem::path& folder);

}  // namespace haarfield
