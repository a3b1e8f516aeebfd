#pragma once
/// Vertices at which other triangles of a mesh cross its surface, as in leaf cards that cross in an X.

#include "fields/mesh/mesh.h"

#include <cstddef>

namespace haarfield {

/// Splits vertices at which another triangle rises from the front of the surface, into one vertex for each
/// side of that triangle. The light differs between the two sides. A single vertex would lie in the plane of
/// that triangle, where visibility is undefined.
///
/// Triangles at less than 25 degrees to the surface, or farther away than surface_offset, are ignored.
///
/// fine      new vertices are appended; triangles keep their order and corners.
/// original  the surface that `fine` subdivides, in the same frame.
/// returns   the number of new vertices.
/// cost      one BVH query per vertex, in parallel.
std::size_t split_crossed_vertices(Mesh& fine, const Mesh& original);

}  // namespace haarfield
