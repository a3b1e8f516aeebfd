#pragma once
/// Shaded meshes as a POV-Ray scene: colours at the vertices, no light.

#include "bridge/povray/povray_scene.h"
#include "scenes/baked_instance.h"

#include <span>

namespace haarfield {

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
