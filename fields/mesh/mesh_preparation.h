#pragma once
/// A mesh made ready: a coarse one that casts shadows, a fine one that is baked. CGAL's work.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/mesh/mesh.h"
#include "fields/mesh/mesh_reader.h"

namespace haarfield {

/// How fine and how coarse the prepared meshes are.
struct MeshPreparation {
    std::uint32_t fine_vertices = 0;     ///< Wanted at least; 0: as it is.
    std::uint32_t coarse_triangles = 0;  ///< Wanted at most; 0: as it is.
};

/// A mesh, made ready; what was read, and what follows from it.
struct PreparedMesh {
    Mesh original;  ///< As read, and mended.
    Mesh backs;     ///< Of the original's sheets, where they can be seen; see sheet_backs.h.
    Mesh fine;      ///< Subdivided: the surface and the backs, at least fine_vertices vertices.
    Mesh coarse;    ///< Simplified: what casts shadows. Positions and triangles matter only.
    MeshFindings findings;
};

/// What is baked: the original and the backs of its sheets.
Mesh seen_surface(const PreparedMesh& prepared);

/// Makes coarse and fine mesh of an imported one.
///
/// fine      see mesh_subdivision.h: the surface does not change, no T-junctions, deterministic; at least
///           fine_vertices, and up to a tenth more where that finishes a round of equal edges. Sheets
///           without thickness are parted (thin_sheets.h).
/// coarse    quadric (Garland-Heckbert) edge collapse down to coarse_triangles; scans of more than some
///           150,000 triangles are first thinned by their shortest edges. What CGAL can not take as a
///           manifold (non-manifold edges) is cut there and still simplified; of the crumbs that this
///           leaves up to a hundredth of the surface is dropped. Many small pieces, or many cuts,
///           can leave more than coarse_triangles.
/// repair    see orient_triangles in mesh_topology.h: triangles agree, closed pieces face outwards.
/// findings  those of the import, self_intersecting (left false above 200,000 triangles), backs and
///           parted_vertices.
/// errors    no triangles; `interrupted`.
/// cost      some 15 microseconds per triangle.
Result<PreparedMesh> prepare_mesh(ImportedMesh imported, const MeshPreparation& wanted,
                                  const Progress& progress = {});

}  // namespace haarfield
