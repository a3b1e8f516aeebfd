#pragma once
/// Scene files in.

#include "fields/base/result.h"
#include "scenes/scene.h"

namespace haarfield {

/// Reads a scene; scenes/SCENE_FILE.md describes it. Paths in it are relative to the file's folder and come
/// back absolute or relative to the working directory, ready to open.
///
/// errors  `file:line:column: ...` for unknown keys, missing keys, wrong types, non-finite numbers,
///         values out of range, unknown entities and materials, files that are not there.
Result<Scene> read_scene(const std::filesystem::path& file);

}  // namespace haarfield
