#pragma once
/// BRDF lobes and the cosine as texels.

#include <span>

#include "fields/wavelets/cubemap.h"

namespace haarfield {

/// Computes the mean of max(0, d.w)^exponent over each texel, by face. 0 < exponent <= 1000. With exponent 1
/// and d the normal it is the clamped cosine; with d the mirror direction, the Phong lobe.
std::vector<float> lobe_texels(float exponent, const Vec3f& direction, int size);

/// Computes a lobe with shared texel centres, for many lobes.
///
/// centres  texel_directions(size).
std::vector<float> lobe_texels(float exponent, const Vec3f& direction, int size,
                               std::span<const Vec3f> centres);

}  // namespace haarfield
