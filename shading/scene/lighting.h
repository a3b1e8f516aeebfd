#pragma once
/// Environment light as wavelets.
///
/// No other factor contains the solid angle. The value of a texel of the lighting is
///
///     radiance (mean over the texel) * solid angle * size^2.   [W/m^2]
///
/// The product integral of the lighting with other functions covers the unit square of each face. Its sum
/// over the six faces is therefore the integral over the sphere.

#include <stop_token>

#include "fields/wavelets/haar_transform.h"
#include "shading/scene/environment.h"

namespace haarfield {

/// Computes lighting texels by face, 6 * size * size; size is a power of two.
///
/// Energy is distributed from pixels to texels by the solid angle of their overlap, in closed form.
///
/// accuracy  exact for piecewise constant pixels, up to rounding to float: energy is preserved for features
///           of any size, and a constant environment gives a constant (times solid angle).
/// cost      about 0.1 s for 1024 x 512 pixels and size 64; 1 s for size 256.
/// stop      once requested, returns soon with unspecified texels.
std::vector<Rgb> lighting_texels(const LatLongImage& environment, int size, const std::stop_token& stop = {});

/// Computes the lighting as quadtrees.
RgbCubemapTree lighting_tree(const LatLongImage& environment, int size, const Truncation& truncation,
                             const std::stop_token& stop = {});

}  // namespace haarfield
