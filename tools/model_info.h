#pragma once
/// What `info` says of models.

#include "tools/command.h"

#include <filesystem>

namespace haarfield {

/// What a model holds: parts, materials, images, size, the axis that seems to point upwards, what was found
/// and mended in its mesh. Into the report goes `model`.
///
/// json  prints that instead of text.
Result<ExitCode> print_model(const std::filesystem::path& file, bool json, CommandContext& context);

}  // namespace haarfield
