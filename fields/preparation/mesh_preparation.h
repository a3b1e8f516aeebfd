#pragma once
/// A mesh made ready: a coarse one that casts shadows, a fine one that is baked. CGAL's work.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/mesh/mesh.h"
#include "fields/model/mesh_reader.h"
#include "fields/preparation/opaque_outline.h"

#include <optional>

namespace haarfield {

/// MeshPreparation::coarse_triangles: the fewest triangles whose surface stays close to the mesh.
inline constexpr std::uint32_t chosen_by_distance = ~std::uint32_t(0);

/// How fine and how coarse the prepared meshes are, and where there are holes in them.
struct MeshPreparation {
    std::uint32_t fine_vertices = 0;     ///< Wanted at least; 0: as it is.
    std::uint32_t coarse_triangles = 0;  ///< Wanted at most; 0: as it is; or chosen_by_distance.
    std::vector<OpacityMap> opacity{};   ///< By the mesh's materials, or none; see cut_outs.h.
    bool split_crossed = true;           ///< split_crossed_vertices of the fine mesh, if there are sheets.
    ClosedFaces faces = ClosedFaces::outwards;  ///< The side on which closed pieces are visible.
};

/// A mesh, made ready; what was read, and what follows from it.
struct PreparedMesh {
    Mesh original;  ///< As read, and mended.
    /// Of the original what blocks light, where images cut into it: see without_cut_outs. Positions and
    /// triangles matter only.
    std::optional<Mesh> opaque{};
    Mesh backs;   ///< Of the original's sheets, where they can be seen; see sheet_backs.h.
    Mesh fine;    ///< Subdivided: the surface and the backs, at least fine_vertices vertices.
    Mesh coarse;  ///< Simplified: what casts shadows. Positions and triangles matter only.
    MeshFindings findings;
};

/// Largest distance (RMS, in radii of the mesh) between a mesh and its coarse version if their number of
/// triangles is chosen_by_distance.
inline constexpr double coarse_distance = 1e-4;

/// What blocks light: the original, or what images leave of it.
const Mesh& blocking_surface(const PreparedMesh& prepared);

/// What is baked: the original and the backs of its sheets.
Mesh seen_surface(const PreparedMesh& prepared);

/// Makes coarse and fine mesh of an imported one.
///
/// fine      see mesh_subdivision.h: the surface does not change, no T-junctions, deterministic; at least
///           fine_vertices, and up to a tenth more where that finishes a round of equal edges. Sheets
///           without thickness are parted (thin_sheets.h), and vertices are split where sheets cross
///           (crossed_vertices.h).
/// coarse    quadric (Garland-Heckbert) edge collapse down to coarse_triangles; scans of more than some
///           150,000 triangles are first thinned by their shortest edges. What CGAL can not take as a
///           manifold (non-manifold edges) is cut there and still simplified; of the crumbs that this
///           leaves up to a hundredth of the surface is dropped. Many small pieces, or many cuts,
///           can leave more than coarse_triangles.
///           chosen_by_distance: a mesh of at most 4,000 triangles is not changed. Larger meshes are
///           simplified while the RMS distance of the original's vertices from the coarse mesh is at most
///           coarse_distance, to at least 4,000 triangles. Meshes of more than 128,000 triangles are
///           simplified to at most 64,000 at any distance. Meshes that images cut into get 4,000.
/// opaque    at most 100,000 triangles take the place of those that images cut into, or what without_cut_outs
///           says. Where that is more than coarse_triangles the coarse mesh is no simplification of them, but
///           a coarser cut with at most half of coarse_triangles; the other half is for the rest. All that is
///           seen stays uncut: its image shows the holes.
/// repair    see orient_triangles in mesh_topology.h: triangles agree, closed pieces face outwards.
/// findings  those of the import, self_intersecting (left false above 200,000 triangles), backs and
///           parted_vertices.
/// errors    no triangles; `interrupted`.
/// cost      some 15 microseconds per triangle.
Result<PreparedMesh> prepare_mesh(ImportedMesh imported, const MeshPreparation& wanted,
                                  const Progress& progress = {});

}  // namespace haarfield
