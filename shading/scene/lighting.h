#pragma once
/// Environment light as wavelets.
///
/// The solid angle enters here, and nowhere else: a texel of the lighting holds
///     radiance (mean over the texel) * solid angle * size^2,
/// so that the product integral of the lighting with other functions over the unit square of each
/// face, added over the six faces, is their integral over the sphere. [W/m^2]

#include <stop_token>

#include "fields/wavelets/haar_transform.h"
#include "shading/scene/environment.h"

namespace haarfield {

/// Lighting texels, face by face, 6 * size * size; size a power of two.
///
/// Energy goes from pixels to texels by the solid angle in which they overlap, in closed form.
///
/// accuracy  exact for piecewise constant pixels, up to rounding to float: the energy of any feature,
///           however small, arrives, and a constant environment comes out constant (times solid angle).
/// cost      some 0.1 s for 1024 x 512 pixels and size 64; 1 s for size 256.
/// stop      when it is requested, returns soon, and the texels are of no use.
std::vector<Rgb> lighting_texels(const LatLongImage& environment, int size, const std::stop_token& stop = {});

/// The same as quadtrees.
RgbCubemapTree lighting_tree(const LatLongImage& environment, int size, const Truncation& truncation,
                             const std::stop_token& stop = {});

}  // namespace haarfield
