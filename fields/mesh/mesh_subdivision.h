#pragma once
/// Subdivision of meshes that preserves the surface.

#include "fields/base/progress.h"
#include "fields/mesh/mesh.h"

namespace haarfield {

/// Splits edges at their midpoints, longest first, until there are `vertices` vertices. Then continues
/// through edges of the same length (0.1 %), up to a tenth more vertices, so that a regular shape gets a
/// regular mesh. A mesh with at least `vertices` vertices is not changed.
///
/// A split divides every triangle at the edge, also across seams where only positions are shared, so that
/// there are no new T-junctions. The normal of a new vertex is the normalised mean of the normals at its
/// edge's ends. Each edge is the longest of all its triangles, so this is Rivara's bisection: angles stay
/// above half of the smallest in the input, and needles and caps improve.
///
/// returns  the current mesh if a stop is requested; fewer vertices if single precision cannot represent
///          midpoints.
/// cost     n log n: 0.1 s per 100,000 new vertices.
/// source   Rivara 1984, Algorithms for refining triangular grids suitable for adaptive and multigrid
///          techniques.
Mesh subdivided(Mesh mesh, std::uint32_t vertices, const Progress& progress = {});

}  // namespace haarfield
