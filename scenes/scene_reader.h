#pragma once
/// Reads scene files.

#include "fields/base/result.h"
#include "scenes/scene.h"

namespace haarfield {

/// Reads a scene; scenes/SCENE_FILE.md describes the format. Paths in the file are relative to its directory.
/// They are returned absolute, or relative to the working directory.
///
/// errors  `file:line:column: ...` for unknown or missing keys, wrong types, non-finite numbers, values out
///         of range, unknown entities and materials, and missing files.
Result<Scene> read_scene(const std::filesystem::path& file);

}  // namespace haarfield
