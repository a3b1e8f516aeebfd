#pragma once
/// Sheets that are modelled with two sides and no thickness between them.

#include "fields/mesh/mesh.h"

#include <cstddef>

namespace haarfield {

/// Parts what lies on its own back: a solid extruded by nothing, a sheet modelled once from each side. A
/// renderer sees the one or the other there by chance, and only one of them is lit. The vertices of a
/// triangle move outwards along their normals by surface_offset if the back of another triangle lies within
/// that distance of its middle, so that of two such sides each shows its own colours. Solids that touch are
/// left alone.
///
/// fine      changes by 1e-4 radii at such places only.
/// original  the surface that `fine` subdivides; its triangles agree (orient_triangles).
/// returns   how many vertices were moved.
/// cost      a ray per triangle, on all cores, and an inside query where a back is found.
std::size_t part_thin_sheets(Mesh& fine, const Mesh& original);

}  // namespace haarfield
