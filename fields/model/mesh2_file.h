#pragma once
/// POV-Ray's `mesh2` objects, as exporters write them into .inc and .pov files.

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

/// A triangle; each corner has a position, and may have a normal, a uv and a texture.
struct Mesh2Face {
    static constexpr std::uint32_t none = UINT32_MAX;
    std::array<std::uint32_t, 3> positions{none, none, none};
    std::array<std::uint32_t, 3> normals{none, none, none};  ///< All or none.
    std::array<std::uint32_t, 3> uvs{none, none, none};      ///< All or none.
    std::array<std::uint32_t, 3> textures{none, none,
                                          none};  ///< All or none; one for the face is three equal.
};

/// One `mesh2 { ... }`, with the transformations that are written within it applied.
struct Mesh2 {
    std::string name;                       ///< Of `#declare NAME = mesh2`; "" without.
    std::size_t line = 0;                   ///< Where it begins, from 1.
    std::vector<Vec3f> positions;           ///< Numbers out of range are infinite.
    std::vector<Vec3f> normals;             ///< Of any length.
    std::vector<std::array<float, 2>> uvs;  ///< v = 0 is the bottom of a picture.
    std::vector<Mesh2Face> faces;           ///< Indices are checked.
    std::vector<std::string> textures;      ///< NAME where the list has `texture { NAME }`, else "".
    std::string material;  ///< NAME of `texture { NAME }` or `material { NAME }` for all of it.
};

/// A mesh where it stands.
struct PlacedMesh2 {
    std::size_t mesh = 0;  ///< Which one.
    AffineMap transform;   ///< From the mesh, as it is kept here, into the file's frame.
    std::string material;  ///< As that of Mesh2, but of the objects round it, the innermost first.
};

/// What a file declares and places.
struct Mesh2File {
    std::vector<Mesh2> meshes;        ///< In the order of the file; none without faces is left out.
    std::vector<PlacedMesh2> placed;  ///< In the order of the file; each mesh at least once.
    std::vector<ModelLight> lights;   ///< That are plain data, and in no union, declaration or condition;
    std::size_t unread_lights = 0;    ///< how many others there are.
    bool left_handed = true;          ///< is_left_handed of the text.
};

/// Reads the meshes of a text in POV-Ray's language as plain data; nothing is run and no other file is read.
///
/// Taken are mesh2 objects of plain numbers (`-1.5*x` is one, too), alone or declared; the places that
/// `object { NAME ... }`, `union` and `merge` give to them with scale, rotate, translate and matrix of plain
/// numbers; and `#ifdef` and `#ifndef` of what this text itself declares. What is declared but stands
/// nowhere, stands as it was declared. And light_sources: povray_light.h. All else is passed over.
/// Coordinates are read as they are written, whatever their handedness.
///
/// errors  (with an empty `where`, and the line) what is not plain data in a mesh or in its place: macros,
///         loops, conditions, identifiers, sums; what POV-Ray refuses in a mesh: counts that do not match,
///         indices out of range, two textures for a face; a mesh in a difference or an intersection; more
///         than 100,000 places; no mesh2.
/// cost    proportional to the bytes, whatever they say, and to the number of places.
/// source  POV-Ray 3.7, reference, 2.4.2.3 Mesh2; a rotation is about x, then y, then z, each by the matrix
///         that turns y towards z, z towards x, x towards y.
Result<Mesh2File> read_mesh2(std::string_view text);

/// Tests whether a text's coordinates are left-handed, as POV-Ray's are. They are right-handed if a camera of
/// the text has a negative `right`, or if haarfield wrote the text.
bool is_left_handed(std::string_view text);

/// Whether the text has a `mesh2` word, outside of comments or not.
bool mentions_mesh2(std::string_view text);

}  // namespace haarfield
