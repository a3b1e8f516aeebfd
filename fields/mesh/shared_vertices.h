#pragma once
/// One vertex for corners of triangles that are alike.

#include "fields/mesh/mesh.h"

#include <algorithm>

namespace haarfield {

/// What of a mesh's appearance tells vertices apart.
struct WantedAppearance {
    std::vector<bool> uvs;  ///< By material: whether an image is used. Of the others' vertices uv is (0, 0).
    std::vector<bool> colours;  ///< By material: whether colours are used. Those of the others are white.
    bool originals = false;     ///< Whether vertices stay apart that are several in the file.

    bool has_uvs() const { return std::ranges::find(uvs, true) != uvs.end(); }
    bool has_colours() const { return std::ranges::find(colours, true) != colours.end(); }
};

/// Each vertex once, in the order in which the triangles use them: corners share one where position, normal,
/// material and what is wanted of the appearance are equal in all bits (-0 is 0). Materials stay as they are.
/// Of several of the file's vertices a shared one has the first's number.
///
/// corner_normals  [3 * triangle + corner].
/// wanted          by the mesh's materials; what is wanted must be there.
Mesh with_shared_vertices(const Mesh& mesh, std::span<const Vec3f> corner_normals,
                          const WantedAppearance& wanted);

/// The same of a mesh whose vertices have their normals: after less of its appearance is wanted.
Mesh with_shared_vertices(const Mesh& mesh, const WantedAppearance& wanted);

}  // namespace haarfield
