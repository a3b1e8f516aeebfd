#pragma once
/// A model as its file lists it, whatever a reader makes of it.

#include "fields/base/vector.h"

#include <cstdint>
#include <vector>

namespace haarfield {

/// The vertices and faces of a file, or of one of its parts: all of them, in the file's order.
///
/// Vertices are counted from 0: those of PLY and OFF as they stand there, OBJ's by their lines `v`, STL's by
/// the corners of facets, glTF's primitive by primitive, mesh2's mesh by mesh. What a file of the last two
/// places several times has vertices at each of its places, one place after the other; a part has them once,
/// and is counted by itself. A part of an OBJ file has the vertices that its faces use, which keep their
/// numbers.
struct ListedMesh {
    std::vector<Vec3f> positions;        ///< In the frame in which read_mesh has them [m]; any numbers.
    std::vector<std::int32_t> numbers;   ///< In the file; one per position, growing.
    std::vector<std::uint32_t> corners;  ///< Of all faces, one face after the other; each a position's index.
    std::vector<std::uint32_t> face_corners;  ///< How many of them are each face's; any number.
};

}  // namespace haarfield
