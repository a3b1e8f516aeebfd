#pragma once
/// Writes shaded meshes as a POV-Ray scene with colours at the vertices and without lights.

#include "bridge/povray/povray_scene.h"
#include "scenes/baked_instance.h"

#include <span>

namespace haarfield {

/// The files that write_baked_scene wrote.
struct BakedFiles {
    std::filesystem::path scene;                  ///< `NAME.pov`
    std::vector<std::filesystem::path> includes;  ///< `NAME_<instance>.inc`, by instance.
    /// The object that each include declares: `Name_Instance`, by instance.
    std::vector<std::string> objects;
    std::vector<std::filesystem::path> images;  ///< Texture images; see write_textures.
    std::uint64_t clamped_vertices = 0;  ///< Vertices with radiance below 0 or above 65000, which is clamped.
};

/// Checks instances for the errors that write_baked_scene reports. Writes nothing.
Result<Done> check_baked_instances(std::span<const BakedInstance> instances);

/// Writes `NAME.pov` and one `NAME_<instance>.inc` per instance, each atomically, the scene file last.
///
/// An include declares one object in world coordinates, which can be placed in any POV-Ray scene. The include
/// has an include guard, preserves the scene's `#version` and prefixes all names. It contains no camera,
/// light or global settings. A comment at its top explains its use. The number of colours determines how they
/// are stored; see colour_storage and MappedLight. Atlases are written next to the include, as
/// `NAME_<instance>.exr`, `.over.exr` and `.places.png`; so are the images of textures. The scene file sets
/// what an include cannot set: assumed_gamma 1, and adc_bailout 0, without which POV-Ray drops the dim
/// corners of triangles.
///
/// scene_name  the stem of the files: letters, digits, `_`, `-`, `.`.
/// errors      non-finite radiance, passes or positions (with instance and vertex); different lengths of
///             radiance, passes and mesh; a texture on a mesh without uvs; a scale outside (0, inf); two
///             instances with the same name; I/O errors.
/// cost        1 s and 160 bytes of text per 150K vertices; instances are written in parallel.
Result<BakedFiles> write_baked_scene(const std::filesystem::path& folder, const std::string& scene_name,
                                     const Camera& camera, std::span<const BakedInstance> instances,
                                     const BackgroundDescription& background);

}  // namespace haarfield
