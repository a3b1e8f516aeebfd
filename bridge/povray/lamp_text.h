#pragma once
/// Lamps in POV-Ray's words.

#include <string>

#include "shading/scene/lamp.h"

namespace haarfield {

/// `light_source { ... }` of a lamp, in a world that is magnified by `scale`. Numbers are finite (asserted).
///
/// factor  of its colour: the name of a number of the scene.
std::string povray_lamp(const Lamp& lamp, double scale, const std::string& factor = {});

}  // namespace haarfield
