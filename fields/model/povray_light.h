#pragma once
/// Lights of POV-Ray files.

#include "fields/model/model_part.h"
#include "fields/model/povray_text.h"

namespace haarfield {

/// Reads the braces of a `light_source`, as far as it is plain data: position, colour (`rgb` of numbers, or
/// White), spotlight, cylinder, parallel, area_light, fading, shadowless, transformations. Skips looks_like
/// and everything that only affects POV-Ray's sampling. Point lights that do not fade are moved to a distance
/// of 1e6 from the origin if they are farther away.
///
/// text     at the opening brace; the original is not advanced.
/// returns  nothing if the light contains anything else, such as identifiers and sums.
std::optional<ModelLight> povray_light(PovrayText text);

}  // namespace haarfield
