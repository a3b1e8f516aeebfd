#pragma once
/// A mesh made ready: a coarse one that casts shadows, a fine one that is baked. CGAL's work.

#include "fields/mesh.h"
#include "fields/mesh_reader.h"
#include "fields/progress.h"
#include "fields/result.h"

namespace haarfield {

struct MeshPreparation {
    std::uint32_t fine_vertices = 0;     ///< Wanted at least; 0: as it is.
    std::uint32_t coarse_triangles = 0;  ///< Wanted at most; 0: as it is.
};

struct PreparedMesh {
    Mesh original;  ///< As read, and mended.
    Mesh fine;      ///< Subdivided: the same surface, at least fine_vertices vertices.
    Mesh coarse;    ///< Simplified: what casts shadows. Positions and triangles matter only.
    MeshFindings findings;
};

/// Makes coarse and fine mesh of an imported one.
///
/// fine    edges are split, longest first, until there are fine_vertices vertices: the surface does
///         not change, normals are interpolated and normalised as a renderer does, there are no
///         T-junctions, and all of it is deterministic.
/// coarse  quadric (Garland-Heckbert) edge collapse down to coarse_triangles, per connected piece
///         where pieces do not share vertices; what CGAL can not take as a manifold (non-manifold edges,
///         duplicate faces) is cut there and still simplified.
/// repair  triangle orientation is made to agree within each piece; closed pieces face outwards.
Result<PreparedMesh> prepare_mesh(ImportedMesh imported, const MeshPreparation& wanted,
                                  const Progress& progress = {});

}  // namespace haarfield
