#pragma once
/// A mixture of two environments.

#include "shading/scene/environment.h"

namespace haarfield {

/// Returns (1 - share) of the first environment plus `share` of the second, with the discs of both.
///
/// share     in [0, 1]; exactly one of the two at 0 and 1.
/// accuracy  images of equal size are added by pixel. Otherwise the one with fewer pixels is interpolated
///           (radiance_from), which preserves energy if its pixels vary smoothly.
/// cost      about 5 ms for 1024 x 512 pixels.
Environment mixed_environment(const Environment& first, const Environment& second, float share);

}  // namespace haarfield
