#pragma once
/// Sheets that are modelled with two sides and no thickness.

#include "fields/mesh/mesh.h"

#include <cstddef>

namespace haarfield {

/// Separates coinciding opposite surfaces: a solid extruded by zero, or a sheet that is modelled once from
/// each side. A renderer would show one or the other at random, and only one of them is lit. The vertices
/// of a triangle move outwards along their normals by surface_offset if the back of another triangle is
/// within that distance of its centroid. Each side then shows its own colours. Solids that touch are not
/// changed. Vertices that such a triangle shares with others stay: where an open wall stands on a floor,
/// the floor next to it would bulge and cover the wall's foot.
///
/// fine      changes by 1e-4 radii, only at such places.
/// original  the surface that `fine` subdivides; consistently oriented (orient_triangles).
/// returns   the number of moved vertices.
/// cost      one ray per triangle, in parallel, and one inside query for each back that is hit.
std::size_t part_thin_sheets(Mesh& fine, const Mesh& original);

}  // namespace haarfield
