#pragma once
/// Where the visibility of the vertices of a fine mesh is sampled.

#include "fields/mesh_preparation.h"
#include "fields/occluder.h"

namespace haarfield {

struct LocalSamples {
    std::vector<Vec3f> points;         ///< One per vertex of the fine mesh: off the surface, beside it. [m]
    std::vector<std::uint8_t> buried;  ///< 1 where all triangles round the vertex lie inside the entity.
};

/// What a vertex of the fine mesh sees of its own entity.
///
/// That is the coarse occluder, unless it has two-sided pieces and the original mesh is small enough (100,000
/// triangles): a simplified two-sided surface passes over some of the vertices that lie on the original one,
/// and would darken them, whereas they lie exactly on the original's own triangles.
Occluder own_occluder(const PreparedMesh& mesh, const Occluder& coarse);

/// A vertex lies on the surface, and on a crease, at a contact or where two pieces meet on other surfaces
/// too, which would be seen edge-on, that is, not at all. So its sample is offset along the normal by
/// surface_offset, and moved by a twentieth of the way towards the middle of the vertex's own triangles that
/// are not buried in another piece. Where a simplified two-sided occluder bulges over the vertex (its back is
/// met along the normal within a fiftieth of the radius), the sample is lifted above the bulge.
///
/// occluder  own_occluder of the mesh.
LocalSamples local_samples(const PreparedMesh& mesh, const Occluder& occluder);

/// The offset of a sample above the surface. [radii]
inline constexpr float surface_offset = 1e-4f;

}  // namespace haarfield
