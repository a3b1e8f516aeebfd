#pragma once
/// Triangulation of polygons.

#include "fields/base/vector.h"

#include <array>
#include <cstdint>
#include <vector>

namespace haarfield {

/// Triangulates a planar or nearly planar polygon without adding vertices.
///
/// Clips the ear with the shortest cut first, so that concave polygons are correct and round ones get no
/// needles. The triangulation of a self-intersecting polygon is arbitrary. Collinear corners may result in
/// triangles without area.
///
/// polygon  finite, at least three corners (asserted).
/// returns  polygon.size() - 2 triangles with the orientation of the polygon, as indices into it.
/// cost     quadratic for mostly convex polygons, cubic in the worst case; above 2000 corners a plain fan.
std::vector<std::array<std::uint32_t, 3>> triangulated(const std::vector<Vec3f>& polygon);

}  // namespace haarfield
