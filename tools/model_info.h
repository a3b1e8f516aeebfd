#pragma once
/// The output of `info` for models.

#include "tools/command.h"

#include <filesystem>

namespace haarfield {

/// Prints a summary of a model: parts, materials, images, size, the probable upward axis, and problems of the
/// mesh that were found and repaired. Adds `model` to the report.
///
/// json  true: prints the summary as JSON.
Result<ExitCode> print_model(const std::filesystem::path& file, bool json, CommandContext& context);

}  // namespace haarfield
