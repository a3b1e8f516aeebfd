#pragma once
/// Reads the lamps of a scene file, `[[lights]]`, and their keyframes.

#include "scenes/scene.h"
#include "scenes/toml_table.h"

#include <span>

namespace haarfield {

/// Reads a lamp; scenes/SCENE_FILE.md describes the keys. Errors are recorded in the table's file.
///
/// instances  the scene's, with their names.
/// before     the lamps read before, whose names may not be used again.
SceneLamp parsed_lamp(TomlTable table, std::span<const Instance> instances,
                      std::span<const SceneLamp> before);

/// Reads one of [[keyframes]] that names a lamp.
///
/// before  the lamp keyframes read before; times of one lamp increase.
LampKeyframe parsed_lamp_keyframe(TomlTable table, std::span<const SceneLamp> lamps,
                                  std::span<const LampKeyframe> before);

}  // namespace haarfield
