#pragma once
/// Simplification of meshes by quadric (Garland-Heckbert) edge collapse. Implemented with CGAL.

#include "fields/base/progress.h"
#include "fields/preparation/mesh_preparation.h"

namespace haarfield {

/// Thrown after a stop request by the functions of this header.
struct Interrupted {};

/// The fewest triangles of a mesh that is simplified by its distance from the original.
inline constexpr std::uint32_t fewest_coarse = 4000;
/// The most triangles of such a mesh, at any distance.
inline constexpr std::uint32_t most_coarse = 64000;

/// Simplifies a mesh. Quadrics cost about 12 microseconds per triangle. A large scan is therefore first
/// thinned by collapsing short edges, to a size at which the effect on the final few thousand triangles is
/// negligible. Returns the mesh unchanged if it has large fans that cannot be flipped. Throws Interrupted.
///
/// wanted  a number of triangles, or chosen_by_distance.
Mesh simplified(const Mesh& mesh, std::size_t wanted, ClosedFaces faces, const Progress& progress);

/// A simplification of a mesh that blocks light for distant points.
struct CoarserMesh {
    Mesh mesh;           ///< Only positions and triangles are used. Orientations are kept.
    float distance = 0;  ///< RMS distance of the original's vertices from it. [m]
};

/// Simplifies a mesh to a third of its triangles, the result again to a third, and so on, down to at least
/// 200 triangles. Ends early where cuts and small pieces prevent it. Throws Interrupted.
///
/// cost  about 20 microseconds per triangle.
std::vector<CoarserMesh> coarser_meshes(const Mesh& mesh, const Progress& progress = {});

}  // namespace haarfield
