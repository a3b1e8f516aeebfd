#pragma once
/// Vertices shared by equal corners of triangles.

#include "fields/mesh/mesh.h"

#include <algorithm>

namespace haarfield {

/// The attributes of appearance that distinguish vertices.
struct DistinctAttributes {
    std::vector<bool> uvs;      ///< By material: true if an image is used. Without one, uv is (0, 0).
    std::vector<bool> colours;  ///< By material: true if colours are used. Otherwise they are white.
    bool originals = false;     ///< True to keep vertices separate that are separate in the file.

    /// True if any material uses an image.
    bool has_uvs() const { return std::ranges::find(uvs, true) != uvs.end(); }
    /// True if any material uses colours.
    bool has_colours() const { return std::ranges::find(colours, true) != colours.end(); }
};

/// Returns a mesh with each distinct vertex once, in the order in which triangles use them. Corners share a
/// vertex if position, normal, material and all wanted appearance are bit-identical (-0 is 0). Materials are
/// unchanged. A shared vertex has the number of the first of its vertices in the file.
///
/// corner_normals  [3 * triangle + corner].
/// wanted          by the mesh's materials; wanted attributes must exist.
Mesh with_shared_vertices(const Mesh& mesh, std::span<const Vec3f> corner_normals,
                          const DistinctAttributes& wanted);

/// Shares vertices of a mesh whose vertices have normals, after fewer attributes are wanted.
Mesh with_shared_vertices(const Mesh& mesh, const DistinctAttributes& wanted);

}  // namespace haarfield
