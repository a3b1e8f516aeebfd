#pragma once
/// PLY and OFF files. assimp 5.2 crashes, hangs or uses gigabytes on damaged ones.

#include "fields/base/result.h"
#include "fields/base/vector.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace haarfield {

/// Vertices and faces as in a file.
struct PolygonFile {
    std::vector<Vec3f> positions;             ///< Numbers out of range become infinite.
    std::vector<Vec3f> normals;               ///< One per position, of any length, or none.
    std::vector<Rgb> colours;                 ///< One per position, linear, any numbers; or none.
    std::vector<Vec2f> uvs;                   ///< One per position, any numbers; or none.
    std::vector<std::uint32_t> corners;       ///< Corners of all faces in turn: indices of positions.
    std::vector<std::uint32_t> face_corners;  ///< The number of corners of each face; any number.
};

/// Reads a PLY file, as text or binary in either byte order. Vertices have x, y, z, nx, ny, nz, red, green,
/// blue, and image coordinates (s and t, u and v, or texture_u and texture_v). Faces have vertex_indices or
/// vertex_index. Other elements and properties are skipped. Integer colours are assumed to be sRGB, floats
/// linear.
///
/// errors  (with an empty `where`) the violation of the format, and its element.
/// cost    proportional to the bytes, even for malicious files.
Result<PolygonFile> read_ply(std::string_view bytes);

/// Reads an OFF file as text with one vertex or face per line. Accepts normals (NOFF) and a fourth coordinate
/// (4OFF), and skips colours and texture coordinates.
///
/// errors  (with an empty `where`) the violation of the format, and its line.
/// cost    as above.
Result<PolygonFile> read_off(std::string_view bytes);

}  // namespace haarfield
