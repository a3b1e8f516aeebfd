#pragma once
/// A mesh in the memory of a program, in the form of a file.

#include "fields/base/vector.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace haarfield {

/// Vertices and triangles. The attributes of vertices have one element per position, or none.
struct MeshInMemory {
    std::vector<Vec3f> positions;  ///< [m]
    std::vector<Vec3f> normals;    ///< One per position, of any length, or none. Zero: compute it.
    std::vector<Vec2f> uvs;        ///< One per position, or none.
    std::vector<Rgb> colours;      ///< One per position, linear, or none.
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Indices of positions.
    /// One per triangle, index in material_names; or none: 0.
    std::vector<std::uint32_t> triangle_materials;
    std::vector<std::string> material_names{""};  ///< At least one.
};

}  // namespace haarfield
