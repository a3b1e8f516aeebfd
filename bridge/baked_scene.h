#pragma once
/// Shaded meshes as a POV-Ray scene: colours at the vertices, no light.

#include "bridge/povray_scene.h"
#include "fields/mesh/listed_mesh.h"
#include "scenes/surface.h"

#include <span>

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

/// What write_baked_scene wrote.
struct BakedFiles {
    std::filesystem::path scene;                  ///< `NAME.pov`
    std::vector<std::filesystem::path> includes;  ///< `NAME_<instance>.inc`, by instance.
    std::vector<std::string> objects;             ///< What each declares: `Name_Instance`, by instance.
    std::vector<std::filesystem::path> images;    ///< Of textures; see write_textures.
    std::uint64_t clamped_vertices = 0;           ///< Radiance below 0 or above 65000, set to the limit.
};

/// What write_baked_scene refuses in its instances; nothing is written.
Result<Done> check_baked_instances(std::span<const BakedInstance> instances);

/// Writes `NAME.pov` and one `NAME_<instance>.inc` per instance, each atomically, the scene file last.
///
/// An include declares one object, in world coordinates, that a POV-Ray user can place in a scene of
/// their own: it is guarded, keeps their `#version`, prefixes its names, has no camera, light or global
/// settings, and says at its top how to use it. Colours are stored as suits their number, see
/// colour_storage and MappedLight; atlases lie beside the include, as `NAME_<instance>.exr`, `.over.exr` and
/// `.places.png`, and so do the images of textures. The scene file sets what an include can not:
/// assumed_gamma 1, and adc_bailout 0, without which POV-Ray drops the dim corners of a triangle.
///
/// scene_name  the stem of the files: letters, digits, `_`, `-`, `.`.
/// errors      non-finite radiance, passes or positions (with instance and vertex); radiance, passes and mesh
///             of different lengths; a texture on a mesh without uvs; scale not in (0, inf); two instances of
///             one name; what the disk says.
/// cost        1 s and 160 bytes of text per 150K vertices; all instances are written in parallel.
Result<BakedFiles> write_baked_scene(const std::filesystem::path& folder, const std::string& scene_name,
                                     const Camera& camera, std::span<const BakedInstance> instances,
                                     const BackgroundDescription& background);

}  // namespace haarfield
