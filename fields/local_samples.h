#pragma once
/// Where the visibility of the vertices of a fine mesh is sampled.

#include "fields/mesh.h"
#include "fields/occluder.h"

namespace haarfield {

struct LocalSamples {
    std::vector<Vec3f> points;         ///< One per vertex of the fine mesh: off the surface, beside it. [m]
    std::vector<std::uint8_t> buried;  ///< 1 where all triangles round the vertex lie inside the entity.
};

/// A vertex lies on the surface, and on a crease, at a contact or where two pieces meet on other surfaces
/// too, which would be seen edge-on, that is, not at all. So its sample is offset along the normal by
/// surface_offset, and moved by a twentieth of the way towards the middle of the vertex's own triangles that
/// are not buried in another piece. Where a simplified two-sided occluder bulges over the vertex (its back is
/// met along the normal within a fiftieth of the radius), the sample is lifted above the bulge.
///
/// original, in_original  of the mesh as it was read.
/// own                    what the vertices see of the entity; see EntityOcclusion.
LocalSamples local_samples(const Mesh& fine, const Occluder& original, const InsideTest& in_original,
                           const Occluder& own);

/// The offset of a sample above the surface. [radii]
inline constexpr float surface_offset = 1e-4f;

}  // namespace haarfield
