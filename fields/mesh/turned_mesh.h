#pragma once
/// Meshes, turned.

#include "fields/mesh/mesh_preparation.h"

namespace haarfield {

/// All parts of a prepared mesh, positions and normals, turned by rotation_xyz. [rad]
///
/// returns  equal bits for equal angles; without angles the mesh as it is.
PreparedMesh turned_mesh(PreparedMesh mesh, const Vec3f& angles);

}  // namespace haarfield
