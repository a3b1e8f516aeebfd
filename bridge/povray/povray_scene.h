#pragma once
/// The words of POV-Ray that the baked scene and the reference scene share.
///
/// Frame   POV-Ray's own is left-handed, but its camera takes any three vectors: we write coordinates
///         unchanged and give a right-handed camera. Normals and light directions are unchanged too.
/// Text    numbers never depend on the locale; all names are made from [A-Za-z0-9_].
///
/// A scene file obeys two switches, set on POV-Ray's command line as `Declare=NAME=1`; render_scene
/// uses them to get the objects with their coverage and the background apart:
///     Haarfield_Without_Background   objects before nothing, so that +UA gives coverage
///     Haarfield_Background_Alone     the background, without reading the objects

#include "fields/base/placement.h"
#include "fields/base/result.h"
#include "fields/base/rotation.h"
#include "fields/mesh/mesh.h"
#include "scenes/scene.h"
#include "shading/scene/environment.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// The first of the two switches.
inline constexpr const char* without_background = "Haarfield_Without_Background";
inline constexpr const char* background_alone = "Haarfield_Background_Alone";  ///< The second.

/// What is behind the objects. The image, clean, turned and exposed, must outlive its use.
struct BackgroundDescription {
    const LatLongImage* environment = nullptr;  ///< Null: black.
};

/// An identifier that is safe in POV-Ray: a capital first, so that it is no keyword, then letters,
/// digits and underscores; at most 64 characters. Equal names give equal identifiers; different names
/// may clash (`a-b`, `a_b`): who needs them apart numbers them.
std::string povray_identifier(std::string_view name);

/// Whether a scene may have this name: letters, digits, `_`, `-` and `.`, none of the last in front.
/// It becomes part of file names, which POV-Ray scenes quote.
bool is_scene_name(std::string_view name);

/// `<x, y, z>`, exact: as many digits as the floats need. Components must be finite (asserted).
std::string povray_vector(const Vec3f& v);

/// `matrix <...>`, a transformation that turns an object so.
std::string povray_rotation(const Rotation& rotation);

/// Appends `keyword { n, <x, y, z>, ... }` with all vectors multiplied by `scale`; exact where that is a
/// power of two.
void append_povray_vectors(std::string& text, std::string_view keyword, std::span<const Vec3f> vectors,
                           float scale = 1);

/// Appends `uv_vectors { n, <u, v>, ... }`, exact.
void append_povray_uvs(std::string& text, std::span<const Vec2f> uvs);

/// Appends `KEYWORD { n, <a, b, c>, ... }`.
void append_povray_indices(std::string& text, std::string_view keyword,
                           std::span<const std::array<std::uint32_t, 3>> triangles);

/// The names of a scene's objects, each given once, in the order of `names`: the scene's identifier, `_`,
/// and the instance's, numbered where two would be equal.
std::vector<std::string> povray_object_names(std::string_view scene_name, std::span<const std::string> names);

/// `camera { ... }` of a picture camera.width by camera.height. World and camera are magnified by
/// `scale` (> 0). The pixel's centre (i + 1/2, j + 1/2) looks along
///     direction + ((i+1/2)/width - 1/2) right + (1/2 - (j+1/2)/height) up.
///
/// errors    eye at the target; non-finite numbers; field of view not inside (0, pi); no pixels.
Result<std::string> povray_camera(const Camera& camera, double scale = 1);

/// Writes the environment as `<stem>_environment.exr` into the folder (half floats, so clamped to
/// 65000) and returns the `sky_sphere` that shows it, guarded by the switches above. Without an
/// environment: a black background, and no file.
Result<std::string> write_background(const std::filesystem::path& folder, const std::string& stem,
                                     const BackgroundDescription& background);

/// 2^k such that the mesh's triangles, magnified so, are large enough for POV-Ray to interpolate over:
/// the shortest edge 0.1, the smallest area 0.005, where the coordinates' size allows it.
///
/// POV-Ray 3.7 loses the barycentric weights of triangles with edges below about 0.1 units, and rays of
/// more than 1e7 units. A power of two is lossless.
double small_triangle_scale(const Mesh& mesh);

/// A rotation R for a mesh that POV-Ray interpolates colours over: write R v for each vertex v, and
/// `matrix <R, 0,0,0>`, row by row, behind the mesh, which takes it back.
///
/// POV-Ray 3.7 finds the barycentric weights in the projection of a triangle along z, however narrow that is,
/// unless it vanishes: a triangle that is almost parallel to z gets wild colours, as they occur in every
/// surface that is extruded along z. So a mesh that has any is turned such that the triangle most parallel to
/// z is as far from it as can be had.
Rotation interpolation_rotation(const Mesh& mesh);

/// Whether a triangle is too narrow for POV-Ray to interpolate over, even magnified by `scale`: it needs one
/// texture for all of it, or its colours come out wrong.
bool is_sliver(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle, double scale);

/// Whether POV-Ray can show a mesh: it would accept one with non-finite positions, and show nothing.
///
/// where     first in the error's message.
/// errors    non-finite positions, or beyond 1e6 m; no triangle; an index out of range.
Result<Done> check_povray_mesh(const Mesh& mesh, const std::string& where);

/// Whether an instance stands where POV-Ray can show it.
///
/// errors    a translation that is not finite or beyond 1e6 m; a scale not in (0, 1e6];
///           a rotation that is not finite.
Result<Done> check_placement(const std::string& where, const Placement& placement);

}  // namespace haarfield
