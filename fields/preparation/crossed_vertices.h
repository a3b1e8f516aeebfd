#pragma once
/// Vertices where other triangles of a mesh cross its surface, as with leaf cards that cross in an X.

#include "fields/mesh/mesh.h"

#include <cstddef>

namespace haarfield {

/// Splits vertices through which a triangle passes that stands on the front of their surface: each side of
/// that triangle gets a vertex of its own. The light differs on the two sides, and a vertex that belongs to
/// both lies in the plane of that triangle, where visibility is undefined.
///
/// Triangles at less than 25 degrees from the surface do not count, nor do those farther away than
/// surface_offset.
///
/// fine      gets the new vertices behind the others; triangles keep their order and corners.
/// original  the surface that `fine` subdivides, in the same place.
/// returns   the number of new vertices.
/// cost      a query of a BVH per vertex, on all cores.
std::size_t split_crossed_vertices(Mesh& fine, const Mesh& original);

}  // namespace haarfield
