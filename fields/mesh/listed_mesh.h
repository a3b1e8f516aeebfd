#pragma once
/// Models as their files list them, independent of the reader.

#include "fields/base/vector.h"

#include <cstdint>
#include <vector>

namespace haarfield {

/// The vertices and faces of a file, or of one of its parts: all of them, in the file's order.
///
/// Vertices are numbered from 0: in PLY and OFF files by their order, in OBJ files by lines `v`, in STL files
/// by corners of facets, in glTF files by primitive, in mesh2 files by mesh. An object that a glTF or mesh2
/// file places several times has vertices for each placement in turn. A part has them once, and is numbered
/// separately. A part of an OBJ file has the vertices that its faces use, with their numbers in the file.
struct ListedMesh {
    std::vector<Vec3f> positions;             ///< In the frame of read_mesh [m]; may be any numbers.
    std::vector<std::int32_t> numbers;        ///< Numbers in the file, increasing; one per position.
    std::vector<std::uint32_t> corners;       ///< Corners of all faces in turn: indices of positions.
    std::vector<std::uint32_t> face_corners;  ///< The number of corners of each face; any number.
};

}  // namespace haarfield
