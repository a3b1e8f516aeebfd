#pragma once
/// Visible backs of sheets that are modelled with one side.

#include "fields/mesh/mesh.h"

namespace haarfield {

/// Returns the visible backs of open surfaces: their triangles reversed, at the same positions, with separate
/// normals. A renderer lights a sheet on the side from which it is viewed. Vertex colours therefore need one
/// vertex per side.
///
/// A few rays are traced from each triangle of an open piece, or of a room whose walls have no thickness
/// (PieceKind::room). The back is visible if some of these rays leave the mesh's bounding box sideways or
/// upwards, or reach the inside of a room. Below is the ground, so that floors and the insides of objects on
/// the ground have no visible backs. Triangles next to visible backs are tested again with more rays, and
/// small groups of triangles among visible backs count as visible. A triangle that is already modelled with a
/// back gets no second one.
///
/// mesh      consistently oriented (orient_triangles).
/// blocking  the part of it that blocks rays; the mesh itself if no image cuts holes into it.
/// returns   an empty mesh if there are none; materials as in `mesh`.
/// cost      16 rays per triangle of such a piece, 64 if it is large, and 128 more at the border of the
///           visible backs; in parallel.
Mesh seen_backs(const Mesh& mesh, const Mesh& blocking);

}  // namespace haarfield
