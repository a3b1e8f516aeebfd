#pragma once
/// PLY and OFF files. assimp 5.2 crashes, hangs or takes gigabytes on damaged ones.

#include "fields/base/result.h"
#include "fields/base/vector.h"

#include <cstdint>
#include <string_view>
#include <vector>

namespace haarfield {

/// Vertices and faces as a file lists them.
struct PolygonFile {
    std::vector<Vec3f> positions;        ///< Numbers out of range are infinite.
    std::vector<Vec3f> normals;          ///< One per position, of any length; or none.
    std::vector<Rgb> colours;            ///< One per position, linear, any numbers; or none.
    std::vector<std::uint32_t> corners;  ///< Of all faces, one face after the other; each a position's index.
    std::vector<std::uint32_t> face_corners;  ///< How many of them are each face's; any number.
};

/// Reads a PLY file, as text or binary of either byte order. Elements but `vertex` and `face`, and properties
/// but x, y, z, nx, ny, nz, red, green, blue and vertex_indices (or vertex_index), are passed over. Colours
/// that are whole numbers are taken as sRGB, floats as linear.
///
/// errors  (with an empty `where`) what is not as the format wants it, and at which element.
/// cost    proportional to the bytes, whatever they say.
Result<PolygonFile> read_ply(std::string_view bytes);

/// Reads an OFF file as text, one vertex or face a line, with colours and texture coordinates (passed over),
/// normals (NOFF) or a fourth coordinate (4OFF).
///
/// errors  (with an empty `where`) what is not as the format wants it, and in which line.
/// cost    as above.
Result<PolygonFile> read_off(std::string_view bytes);

}  // namespace haarfield
