#pragma once
/// A mesh that a program holds, as a file would list it.

#include "fields/base/vector.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace haarfield {

/// Vertices and triangles. What is there once for each vertex may have another length of none.
struct GivenMesh {
    std::vector<Vec3f> positions;  ///< [m]
    std::vector<Vec3f> normals;    ///< One per position, of any length; or none. Zero: to be found.
    std::vector<Vec2f> uvs;        ///< One per position, or none.
    std::vector<Rgb> colours;      ///< One per position, linear, or none.
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Indices of positions.
    std::vector<std::uint32_t>
        triangle_materials;                       ///< One per triangle, index in material_names; or none: 0.
    std::vector<std::string> material_names{""};  ///< At least one.
};

}  // namespace haarfield
