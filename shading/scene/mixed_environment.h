#pragma once
/// Two environments as one light.

#include "shading/scene/environment.h"

namespace haarfield {

/// (1 - share) of the first and `share` of the second, with the discs of both that shed light.
///
/// share     in [0, 1]; at 0 and 1 it is one of the two, to the last bit.
/// accuracy  images of one size are added pixel by pixel; otherwise the one with fewer pixels is interpolated
///           (radiance_from), which keeps its energy to the smoothness of its pixels.
/// cost      some 5 ms for 1024 x 512 pixels.
Environment mixed_environment(const Environment& first, const Environment& second, float share);

}  // namespace haarfield
