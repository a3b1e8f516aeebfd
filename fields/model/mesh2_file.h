#pragma once
/// POV-Ray's `mesh2` objects in .inc and .pov files.

#include "fields/base/affine_map.h"
#include "fields/base/result.h"
#include "fields/base/vector.h"
#include "fields/model/model_part.h"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// A triangle. Each corner has a position, and may have a normal, a uv and a texture.
struct Mesh2Face {
    static constexpr std::uint32_t none = UINT32_MAX;
    std::array<std::uint32_t, 3> positions{none, none, none};
    std::array<std::uint32_t, 3> normals{none, none, none};  ///< All or none.
    std::array<std::uint32_t, 3> uvs{none, none, none};      ///< All or none.
    /// All or none; three equal ones for a texture of the whole face.
    std::array<std::uint32_t, 3> textures{none, none, none};
};

/// A `mesh2 { ... }`, with the transformations within its braces applied.
struct Mesh2 {
    std::string name;                       ///< NAME of `#declare NAME = mesh2`, or "".
    std::size_t line = 0;                   ///< Line of its first word, from 1.
    std::vector<Vec3f> positions;           ///< Numbers out of range become infinite.
    std::vector<Vec3f> normals;             ///< Of any length.
    std::vector<std::array<float, 2>> uvs;  ///< v = 0 is the bottom of a picture.
    std::vector<Mesh2Face> faces;           ///< Indices are checked.
    std::vector<std::string> textures;      ///< NAME for each `texture { NAME }` of the list, or "".
    /// NAME of a `texture { NAME }` or `material { NAME }` that applies to the whole mesh.
    std::string material;
};

/// A placement of a mesh.
struct PlacedMesh2 {
    std::size_t mesh = 0;  ///< Index in Mesh2File::meshes.
    AffineMap transform;   ///< From the mesh's frame to the file's.
    std::string material;  ///< Like Mesh2::material, but of the innermost enclosing object that has one.
};

/// The meshes and lights that a file declares and places.
struct Mesh2File {
    std::vector<Mesh2> meshes;        ///< In the order of the file, without meshes that have no faces.
    std::vector<PlacedMesh2> placed;  ///< In the order of the file; each mesh at least once.
    std::vector<ModelLight> lights;  ///< Those in plain data, outside of unions, declarations and conditions.
    std::size_t unread_lights = 0;   ///< The number of other lights.
    bool left_handed = true;         ///< is_left_handed of the text.
};

/// Reads the meshes in a text in POV-Ray's language as plain data. Runs no code and reads no other files.
///
/// Reads mesh2 objects of plain numbers (including `-1.5*x`), alone or declared. Reads their placements by
/// `object { NAME ... }`, `union` and `merge` with scale, rotate, translate and matrix of plain numbers.
/// Evaluates `#ifdef` and `#ifndef` of names that the text itself declares. A mesh that is declared but not
/// placed is placed as declared. Reads light_sources (povray_light.h). Skips everything else. Coordinates are
/// read as written, with either handedness.
///
/// errors  (with an empty `where`, and the line) anything but plain data in a mesh or its placement: macros,
///         loops, conditions, identifiers, sums; a mesh that POV-Ray rejects: counts that do not match,
///         indices out of range, two textures for a face; a mesh in a difference or an intersection; more
///         than 100,000 placements; no mesh2.
/// cost    proportional to the bytes, even for malicious files, and to the number of placements.
/// source  POV-Ray 3.7, reference, 2.4.2.3 Mesh2. A rotation is about x, then y, then z, each by the matrix
///         that rotates y towards z, z towards x, x towards y.
Result<Mesh2File> read_mesh2(std::string_view text);

/// Tests whether a text's coordinates are left-handed, as POV-Ray's are. They are right-handed if a camera of
/// the text has a negative `right`, or if haarfield wrote the text.
bool is_left_handed(std::string_view text);

/// Tests whether the text contains the word `mesh2`, even in a comment.
bool mentions_mesh2(std::string_view text);

}  // namespace haarfield
