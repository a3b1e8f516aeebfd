#pragma once
/// Preparation of a mesh: a coarse version that casts shadows and a fine version that is baked. Implemented
/// with CGAL.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/mesh/mesh.h"
#include "fields/model/mesh_reader.h"
#include "fields/preparation/opaque_outline.h"

#include <optional>

namespace haarfield {

/// MeshPreparation::coarse_triangles: the fewest triangles whose surface stays close to the mesh.
inline constexpr std::uint32_t chosen_by_distance = ~std::uint32_t(0);

/// The resolutions of the prepared meshes, and their opacity.
struct MeshPreparation {
    std::uint32_t fine_vertices = 0;     ///< Minimum; 0: unchanged.
    std::uint32_t coarse_triangles = 0;  ///< Maximum; 0: unchanged; or chosen_by_distance.
    std::vector<OpacityMap> opacity{};   ///< One per material of the mesh, or none; see cut_outs.h.
    bool split_crossed = true;  ///< Apply split_crossed_vertices to the fine mesh if there are sheets.
    ClosedFaces faces = ClosedFaces::outwards;  ///< The side on which closed pieces are visible.
};

/// A prepared mesh: its original and the meshes derived from it.
struct PreparedMesh {
    Mesh original;  ///< As read, and repaired.
    /// The part of the original that blocks light, if images cut into it: see without_cut_outs. Only
    /// positions and triangles are used.
    std::optional<Mesh> opaque{};
    Mesh backs;   ///< Visible backs of the original's sheets; see sheet_backs.h.
    Mesh fine;    ///< Subdivided surface and backs, with at least fine_vertices vertices.
    Mesh coarse;  ///< Simplified, for casting shadows. Only positions and triangles are used.
    MeshFindings findings;
};

/// The largest RMS distance between a mesh and its coarse version, in radii of the mesh, if coarse_triangles
/// is chosen_by_distance.
inline constexpr double coarse_distance = 1e-4;

/// Returns the mesh that blocks light: the original, or `opaque` if images cut into it.
const Mesh& blocking_surface(const PreparedMesh& prepared);

/// Returns the mesh to bake: the original and the backs of its sheets.
Mesh visible_surface(const PreparedMesh& prepared);

/// Makes the coarse and the fine version of an imported mesh.
///
/// fine      see mesh_subdivision.h: the surface does not change, no T-junctions, deterministic; at least
///           fine_vertices, and up to a tenth more if that completes a round of equal edges. Sheets without
///           thickness are separated (thin_sheets.h), and vertices are split where sheets cross
///           (crossed_vertices.h).
/// coarse    quadric (Garland-Heckbert) edge collapse down to coarse_triangles. In meshes of more than about
///           150,000 triangles, the shortest edges are collapsed first. Non-manifold edges, which CGAL does
///           not support, are cut. Of the fragments that this leaves, up to a hundredth of the surface is
///           dropped. Many small pieces, or many cuts, can leave more than coarse_triangles.
///           chosen_by_distance: a mesh of at most 4,000 triangles is not changed. Larger meshes are
///           simplified while the RMS distance of the original's vertices from the coarse mesh is at most
///           coarse_distance, to at least 4,000 triangles. Meshes of more than 128,000 triangles are
///           simplified to at most 64,000 at any distance. Meshes that images cut into get 4,000.
/// opaque    triangles that images cut are replaced by at most 100,000, with the exceptions of
///           without_cut_outs. If these are more than coarse_triangles, the coarse mesh is not a
///           simplification of them but a coarser cut with at most half of coarse_triangles; the other half
///           is for the uncut triangles. The fine mesh stays uncut: its images show the holes.
/// repair    see orient_triangles in mesh_topology.h: consistent orientation, closed pieces face outwards.
/// findings  those of the import, self_intersecting (left false above 200,000 triangles), backs and
///           parted_vertices.
/// errors    no triangles; `interrupted`.
/// cost      about 15 microseconds per triangle.
Result<PreparedMesh> prepare_mesh(ImportedMesh imported, const MeshPreparation& wanted,
                                  const Progress& progress = {});

}  // namespace haarfield
