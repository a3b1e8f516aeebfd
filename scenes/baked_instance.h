#pragma once
/// Instances with the radiance of their vertices, for pictures and files.

#include "scenes/scene_entities.h"

#include <span>
#include <string>
#include <vector>

namespace haarfield {

/// A pass of a bake at the vertices of a mesh, for files that store more than radiance.
struct VertexValues {
    std::string name;             ///< Lower case letters and _; `own_shadow`. Unique in its instance.
    std::span<const Rgb> values;  ///< One per vertex of the mesh.
    bool is_scalar = false;       ///< True: the three channels are equal and represent one number.
};

/// An instance as it is displayed, in pictures and in files. The mesh and the spans must outlive its use.
struct BakedInstance {
    std::string name;            ///< Unique in its scene, where files use it.
    const Mesh* mesh = nullptr;  ///< The fine mesh, or another one of the same surface.
    Placement placement;
    std::span<const Rgb> radiance;        ///< LayeredRadiance::textured, one per vertex. [W/(m^2 sr)]
    std::span<const Rgb> added{};         ///< LayeredRadiance::added, one per vertex, or none.
    std::span<const Surface> surfaces{};  ///< By the material indices of the mesh; none: all are plain.
    std::vector<VertexValues> passes{};   ///< The same names in all instances (asserted). Not for POV-Ray.
    /// Faces instead of the triangles of the mesh, with the same vertices, for file formats that have
    /// polygons; see OriginalBake.
    const ListedMesh* listed = nullptr;
    bool shows_reflection = true;  ///< False: surfaces reflect nothing, as in passes.
    bool left_handed = false;      ///< The coordinates are those of a left-handed POV-Ray file.
};

/// Returns an instance of a scene as it is displayed.
///
/// mesh      the fine mesh of the entity, or another one of its surface.
/// radiance  by vertex; empty: `layers` remains unchanged.
/// layers    receives the radiance, separated from the textures. It must outlive the result.
BakedInstance baked_instance(const Instance& instance, const SceneEntity& entity, const Mesh& mesh,
                             std::span<const Outgoing> radiance, LayeredRadiance& layers);

/// Returns the image on a triangle of the mesh, or null if there is none.
const Texture* texture_of(const BakedInstance& instance, const std::array<std::uint32_t, 3>& triangle);

/// Returns the radiance of a vertex, with the colour of its texture there.
Rgb displayed_radiance(const BakedInstance& instance, std::size_t vertex);

}  // namespace haarfield
