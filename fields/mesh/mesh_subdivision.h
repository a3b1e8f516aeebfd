#pragma once
/// A finer triangulation of the same surface.

#include "fields/base/progress.h"
#include "fields/mesh/mesh.h"

namespace haarfield {

/// Splits edges at their middle, longest first, until there are `vertices` vertices, and then on
/// through edges of the same length (0.1 %), up to a tenth more vertices, so that a regular shape gets
/// a regular mesh. A mesh that has as many already stays as it is.
///
/// A split divides every triangle round the edge, also across seams where only positions are
/// shared: there are no new T-junctions. The normal of a new vertex is the normalised mean of its
/// edge's ends. As an edge is always the longest of all its triangles this is Rivara's bisection:
/// angles stay above half of the smallest in the input, and needles and caps get better.
///
/// returns  the mesh so far if a stop is requested; fewer vertices if edges can not be halved in
///          single precision.
/// cost     n log n: 0.1 s per 100,000 new vertices.
/// source   Rivara 1984, Algorithms for refining triangular grids suitable for adaptive and multigrid
///          techniques.
Mesh subdivided(Mesh mesh, std::uint32_t vertices, const Progress& progress = {});

}  // namespace haarfield
