#pragma once
/// Sheets that are modelled with one side.

#include "fields/mesh/mesh.h"

namespace haarfield {

/// The backs of an open surface that can be seen: its triangles turned round, at the same places, with
/// normals of their own. A renderer lights a sheet from the side that it is looked at; vertex colours need a
/// vertex for each side.
///
/// A triangle of an open piece, or of a room whose walls have no thickness (PieceKind::room), has a back
/// where some of a few rays from it leave the mesh's box sideways or upwards, or reach the inside of a room.
/// Below is the ground, so that neither a floor nor the inside of what stands on it has any. Triangles next
/// to visible backs are tested again with more rays, and small groups of triangles among visible backs count
/// as visible. A triangle that is modelled with a back of its own gets no second one.
///
/// mesh      its triangles agree (orient_triangles).
/// blocking  what of it can not be looked through; the mesh itself, if no image cuts holes into it.
/// returns   an empty mesh if there are none; materials as in `mesh`.
/// cost      16 rays per triangle of such a piece, 64 where it is large, and 128 more at the border of the
///           visible backs; on all cores.
Mesh seen_backs(const Mesh& mesh, const Mesh& blocking);

}  // namespace haarfield
