#pragma once
/// Writes lamps in POV-Ray's language.

#include <string>

#include "shading/scene/lamp.h"

namespace haarfield {

/// Returns the `light_source { ... }` of a lamp, in a world that is magnified by `scale`. Numbers are finite
/// (asserted).
///
/// factor  the name of a number in the scene that multiplies the colour; empty: none.
std::string povray_lamp(const Lamp& lamp, double scale, const std::string& factor = {});

}  // namespace haarfield
