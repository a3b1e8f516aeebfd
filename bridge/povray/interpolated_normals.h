#pragma once
/// Vertex normals that POV-Ray interpolates in every triangle.
///
/// POV-Ray 3.7 ignores the vertex normals of a triangle whose three normals differ by less than 1e-5. It
/// shades such a triangle with the geometric normal, even if the vertex normals point elsewhere, as in
/// flat-shaded models of quads that are not planar.

#include "fields/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace haarfield {

/// Normals of a mesh2, and their indices by triangle.
struct InterpolatedNormals {
    std::vector<Vec3f> normals;                         ///< The mesh's own, then the tilted ones.
    std::vector<std::array<std::uint32_t, 3>> indices;  ///< Empty: the triangles' own.
};

/// The mesh's normals, with one corner tilted by 1e-4 rad in each triangle whose normals agree with each
/// other but not with the geometric normal.
///
/// accuracy  the interpolated normal is off by at most 1e-4 rad.
InterpolatedNormals interpolated_normals(const Mesh& mesh);

}  // namespace haarfield
