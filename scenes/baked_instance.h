#pragma once
/// Instances with the radiance of their vertices, for pictures and files.

#include "fields/base/placement.h"
#include "fields/mesh/listed_mesh.h"
#include "scenes/surface.h"

#include <span>
#include <string>
#include <vector>

namespace haarfield {

/// What else is known of a mesh's vertices, for files that take more than radiance.
struct VertexValues {
    std::string name;             ///< Lower case letters and _; `own_shadow`. Unlike the others.
    std::span<const Rgb> values;  ///< One per vertex of the mesh.
    bool is_scalar = false;       ///< The three channels are one number.
};

/// One object. The mesh and the radiance must outlive the call.
struct BakedInstance {
    std::string name;            ///< Unlike all others of the scene.
    const Mesh* mesh = nullptr;  ///< The fine one.
    Placement placement;
    std::span<const Rgb> radiance;  ///< Outgoing, one per vertex of the mesh. [W/(m^2 sr)]
    /// What lies over textures, one per vertex, or none; then `radiance` is what they multiply: SeenRadiance.
    std::span<const Rgb> over{};
    std::span<const Surface> surfaces{};  ///< By the mesh's materials; none: plain ones.
    std::vector<VertexValues> passes{};   ///< The same names in all instances (asserted). Not for POV-Ray.
    /// Faces in place of the mesh's triangles, of the same vertices, where a file takes any; see
    /// OriginalBake.
    const ListedMesh* listed = nullptr;
    bool left_handed = false;  ///< Coordinates are those of a left-handed POV-Ray file.
};

/// The radiance of a vertex, with the colour of its texture there.
Rgb seen_at(const BakedInstance& instance, std::size_t vertex);

}  // namespace haarfield
