#pragma once
/// A mesh as something that blocks light: triangles, and which of them may be seen from behind.

#include "fields/mesh.h"

namespace haarfield {

/// Triangles ready for the visibility rasterizer.
///
/// A closed piece (every edge shared by exactly two triangles that agree in orientation, positive
/// volume) blocks with its front faces only: from outside the union of the pieces that is the whole
/// truth, and a point slightly under a simplified surface is not darkened by its inside. Any other
/// piece blocks with both sides.
struct Occluder {
    std::vector<Vec3f> positions;                         ///< [m]
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< One-sided first, then two-sided.
    std::uint32_t one_sided = 0;                          ///< How many of them are one-sided.
    Bounds bounds;
};

/// From any mesh; normals and materials do not matter. Equal positions are merged first.
Occluder make_occluder(const Mesh& mesh);

/// Whether a point lies inside the closed pieces: their winding number there is positive.
bool is_inside(const Occluder& occluder, const Vec3f& point);

}  // namespace haarfield
