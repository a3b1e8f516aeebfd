#pragma once
/// Whole files out, and the folders that they go to.

#include "fields/base/result.h"

#include <filesystem>
#include <string_view>

namespace haarfield {

/// Writes bytes to a file, which appears whole or not at all: it is a TemporaryFile before. Unlike a field it
/// is not awaited on the disk.
///
/// errors  what the system says (no such folder, full disk ...).
Result<Done> write_file(const std::filesystem::path& file, std::string_view bytes);

/// Makes the folder, with those above it, if it is not there; and removes from it what processes that have
/// ended left half-written (remove_abandoned_files).
///
/// errors  what the system says; a file of that name.
Result<Done> make_folder(const std::filesystem::path& folder);

}  // namespace haarfield
