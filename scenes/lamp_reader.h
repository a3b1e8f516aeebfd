#pragma once
/// Lamps of a scene file: its [[lights]].

#include "scenes/scene.h"
#include "scenes/toml_table.h"

#include <span>

namespace haarfield {

/// A lamp; scenes/SCENE_FILE.md has the keys. What is wrong is refused in the table.
///
/// instances  of the scene, with their names.
/// before     lamps that were read before, whose names are taken.
SceneLamp taken_lamp(TomlTable table, std::span<const Instance> instances, std::span<const SceneLamp> before);

/// One of [[keyframes]] that names a lamp.
///
/// before  those that were read before.
LampKeyframe taken_lamp_keyframe(TomlTable table, std::span<const SceneLamp> lamps,
                                 std::span<const LampKeyframe> before);

}  // namespace haarfield
