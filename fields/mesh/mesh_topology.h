#pragma once
/// Which triangles of a mesh hang together, and which way round they should face.

#include "fields/mesh/closed_pieces.h"
#include "fields/mesh/mesh.h"

#include <span>

namespace haarfield {

/// Vertices by position: where normals or materials part a mesh has several at one place.
struct MergedPositions {
    std::vector<std::uint32_t> index;  ///< One per vertex: its place in `positions`.
    std::vector<Vec3f> positions;      ///< Each one once, in the order of its first vertex. [m]
};

/// Merges positions that are equal (0 and -0 are), without a tolerance.
///
/// cost  linear.
MergedPositions merged_positions(std::span<const Vec3f> positions);

/// Leaves out triangles without area, and all but the first of those that join the same places, whichever way
/// round.
///
/// findings  adds to degenerate_triangles and duplicate_triangles.
/// cost      n log n.
void leave_out_bad_triangles(Mesh& mesh, MeshFindings& findings);

/// Makes triangles agree with their neighbours, turns pieces to face the right way, and counts what it finds.
///
/// Triangles agree across edges that exactly two of them share. A part that is closed then faces
/// outwards (positive volume), or as ClosedFaces says; an open one faces as its normals do, and if there are
/// none, as most of its triangles did. Normals that afterwards look backwards are turned round, on a vertex
/// of their own where triangles differ about that.
///
/// mesh      normals may be zero (missing).
/// findings  sets components, open_components, boundary_edges, non_manifold_edges and
///           duplicate_vertices; adds to flipped_triangles.
/// limits    a one-sided surface (Moebius) keeps a line of disagreement.
/// cost      n log n; a second per two million triangles.
void orient_triangles(Mesh& mesh, MeshFindings& findings, ClosedFaces faces = ClosedFaces::outwards);

/// The closed parts of a mesh, before orient_triangles: whether they face inwards their normals say, and if
/// there are none, most of their triangles.
///
/// cost  n log n.
std::vector<ClosedPiece> closed_pieces(const Mesh& mesh);

/// By triangle: PieceKind.
std::vector<PieceKind> triangle_kinds(const Mesh& mesh);

/// For each triangle the connected piece it belongs to, counted from 0 in the order of the first
/// triangle. Pieces are connected by shared positions.
std::vector<std::uint32_t> triangle_pieces(const Mesh& mesh, const MergedPositions& merged);

/// For each triangle its neighbours across edges that exactly two triangles share, whichever way round they
/// are; UINT32_MAX fills the rest. Vertices at equal positions count as one.
///
/// cost  n log n.
std::vector<std::array<std::uint32_t, 3>> edge_neighbours(const Mesh& mesh);

/// For each triangle whether its piece has an edge with one triangle only: 1 or 0.
std::vector<std::uint8_t> triangles_of_open_pieces(const Mesh& mesh);

}  // namespace haarfield
