#pragma once
/// Connectivity and orientation of triangles.

#include "fields/mesh/closed_pieces.h"
#include "fields/mesh/mesh.h"

#include <span>

namespace haarfield {

/// Vertices merged by position: if normals or materials differ, a mesh has several vertices at one place.
struct MergedPositions {
    std::vector<std::uint32_t> index;  ///< One per vertex: its index in `positions`.
    std::vector<Vec3f> positions;      ///< Distinct positions, in the order of their first vertices. [m]
};

/// Merges exactly equal positions (0 and -0 are equal).
///
/// cost  linear.
MergedPositions merged_positions(std::span<const Vec3f> positions);

/// Removes triangles without area, and all but the first of those that connect the same places in any order.
///
/// findings  adds to degenerate_triangles and duplicate_triangles.
/// cost      n log n.
void leave_out_bad_triangles(Mesh& mesh, MeshFindings& findings);

/// Orients triangles consistently with their neighbours, orients each piece, and counts findings.
///
/// Triangles agree across edges that exactly two of them share. A closed piece then faces outwards (positive
/// volume), or as specified by ClosedFaces. An open piece faces as its normals do, or without normals, as
/// most of its triangles did. Normals that then point backwards are reversed, on a separate vertex if the
/// triangles at a vertex differ.
///
/// mesh      normals may be zero (missing).
/// findings  sets components, open_components, boundary_edges, non_manifold_edges and duplicate_vertices;
///           adds to flipped_triangles.
/// limits    a one-sided surface (Moebius) keeps a line of inconsistent edges.
/// cost      n log n; a second per two million triangles.
void orient_triangles(Mesh& mesh, MeshFindings& findings, ClosedFaces faces = ClosedFaces::outwards);

/// Returns the closed pieces of a mesh, before orient_triangles. `faces_inwards` is determined by their
/// normals, or without normals, by most of their triangles.
///
/// cost  n log n.
std::vector<ClosedPiece> closed_pieces(const Mesh& mesh);

/// Returns the PieceKind of each triangle.
std::vector<PieceKind> triangle_kinds(const Mesh& mesh);

/// Returns the connected piece of each triangle, numbered from 0 in the order of first triangles. Pieces are
/// connected by shared positions.
std::vector<std::uint32_t> triangle_pieces(const Mesh& mesh, const MergedPositions& merged);

/// Returns each triangle's neighbours across edges that exactly two triangles share, in any orientation.
/// Unused elements are UINT32_MAX. Vertices with equal positions count as one.
///
/// cost  n log n.
std::vector<std::array<std::uint32_t, 3>> edge_neighbours(const Mesh& mesh);

/// Returns 1 for each triangle whose piece has an edge with one triangle only, and 0 for all others.
std::vector<std::uint8_t> triangles_of_open_pieces(const Mesh& mesh);

}  // namespace haarfield
