#pragma once
/// The directions along which indirect light is gathered at a point.

#include <span>

#include "fields/base/vector.h"

namespace haarfield {

inline constexpr int least_gathering_rays = 16;   ///< The smallest number of rays.
inline constexpr int most_gathering_rays = 4096;  ///< The largest number of rays.

/// Returns unit directions about z whose density is that of the cosine: those of spiral_direction. Each run
/// of 16 lies in a small part of the hemisphere, so that its rays are a packet.
///
/// rays  a power of two, from least_gathering_rays to most_gathering_rays.
/// cost  a lookup; about 1 ms at the first call.
std::span<const Vec3f> gathering_directions(int rays);

}  // namespace haarfield
