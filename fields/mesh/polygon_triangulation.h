#pragma once
/// N-gons into triangles.

#include "fields/base/vector.h"

#include <array>
#include <cstdint>
#include <vector>

namespace haarfield {

/// Cuts a polygon, flat or nearly so, into triangles of its own corners.
///
/// The ear with the shortest cut goes first, so that a concave polygon stays what it is and a round
/// one gets no needles. A polygon that crosses itself has no right answer and gets any. Corners in a
/// line may give triangles without area.
///
/// polygon  finite, at least three corners (asserted).
/// returns  polygon.size() - 2 triangles, turning as the polygon does; indices into it.
/// cost     quadratic while mostly convex, cubic at worst; above 2000 corners a plain fan.
std::vector<std::array<std::uint32_t, 3>> triangulated(const std::vector<Vec3f>& polygon);

}  // namespace haarfield
