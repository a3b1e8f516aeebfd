#pragma once
/// Small meshes with known shapes, for tests.

#include "fields/mesh_preparation.h"

namespace haarfield {

/// One square in the plane y = height, facing up, `side` wide; cells x cells, two triangles each.
Mesh square_mesh(float side, float height, int cells = 1);

/// One square in the plane z = 0, facing +z, with its middle in the origin; cells x cells.
Mesh upright_square_mesh(float half_edge, int cells = 1);

/// A closed box with sharp edges: four vertices a side, flat normals; each side cells x cells.
Mesh box_mesh(const Vec3f& lower, const Vec3f& upper, int cells = 1);

/// A closed sphere with smooth normals, 2 * segments * (segments - 1) triangles or so.
Mesh sphere_mesh(const Vec3f& centre, float radius, int segments);

/// Both meshes as one.
Mesh joined_meshes(const Mesh& a, const Mesh& b);

/// As prepare_mesh would return it, if it had nothing to do.
PreparedMesh prepared_as_is(const Mesh& mesh);

}  // namespace haarfield
