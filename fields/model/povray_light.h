#pragma once
/// Lights of POV-Ray files.

#include "fields/model/model_part.h"
#include "fields/model/povray_text.h"

namespace haarfield {

/// Reads what stands in the braces of a `light_source`, as far as it is plain data: place, colour (`rgb` of
/// numbers, or White), spotlight, cylinder, parallel, area_light, fading, shadowless, transformations. What
/// changes only how POV-Ray samples, and looks_like, is passed over.
///
/// text     at the first brace; nothing is taken.
/// returns  nothing if something else is in it, such as names and sums.
std::optional<ModelLight> povray_light(PovrayText text);

}  // namespace haarfield
