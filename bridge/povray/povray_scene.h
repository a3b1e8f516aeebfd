#pragma once
/// POV-Ray syntax that the baked scene and the reference scene share.
///
/// Frame   POV-Ray's own frame is left-handed, but its camera accepts any three vectors. Coordinates are
///         written unchanged, with a right-handed camera. Normals and light directions are unchanged too.
/// Text    numbers do not depend on the locale; all names consist of [A-Za-z0-9_].
///
/// A scene file obeys two switches, set on POV-Ray's command line as `Declare=NAME=1`. render_scene uses them
/// to render the objects with their coverage and the background separately:
///     Haarfield_Without_Background   the objects without background, so that +UA gives coverage
///     Haarfield_Background_Alone     the background, without parsing the objects

#include "fields/base/placement.h"
#include "fields/base/result.h"
#include "fields/base/rotation.h"
#include "fields/mesh/mesh.h"
#include "scenes/scene.h"
#include "scenes/surface.h"
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
inline constexpr const char* background_only = "Haarfield_Background_Alone";  ///< The second.

/// The background behind the objects. The image is clean, rotated and exposed, and must outlive its use.
struct BackgroundDescription {
    const LatLongImage* environment = nullptr;  ///< Null: black.
    bool is_reflected = false;                  ///< Objects reflect it even in pictures without background.
    double assumed_gamma = 1;                   ///< Of the scene; radiance is in its numbers.
};

/// Returns a valid POV-Ray identifier: a capital first, which excludes keywords, then letters, digits and
/// underscores; at most 64 characters. Equal names give equal identifiers. Different names may give equal
/// identifiers too (`a-b`, `a_b`); callers that need unique ones number them.
std::string povray_identifier(std::string_view name);

/// Returns a text of POV-Ray in which `gamma` follows the name of each OpenEXR file, so that the files hold
/// numbers of a scene with an assumed_gamma instead of linear light.
std::string with_gamma(std::string text, double assumed_gamma);

/// True if a name is valid for a scene: letters, digits, `_`, `-` and `.`, without a leading `.`. The name
/// becomes part of file names that POV-Ray scenes quote.
bool is_scene_name(std::string_view name);

/// Returns `<x, y, z>`, exact, with as many digits as the floats need. Components must be finite (asserted).
std::string povray_vector(const Vec3f& v);

/// Returns `matrix <...>`, the transformation that rotates an object.
std::string povray_rotation(const Rotation& rotation);

/// Returns the keyword `reflection` of a finish; empty if there is no reflection. The object needs the index
/// of refraction in its `interior`.
///
/// share  factor of both colours.
std::string povray_reflection(const Reflection& reflection, float share = 1);

/// Returns the `interior` that the reflections of a mesh need; empty if none does.
std::string povray_interior(std::span<const Surface> surfaces);

/// Appends `keyword { n, <x, y, z>, ... }` with all vectors multiplied by `scale`; exact if `scale` is a
/// power of two.
void append_povray_vectors(std::string& text, std::string_view keyword, std::span<const Vec3f> vectors,
                           float scale = 1);

/// Appends `uv_vectors { n, <u, v>, ... }`, exact.
void append_povray_uvs(std::string& text, std::span<const Vec2f> uvs);

/// Appends `KEYWORD { n, <a, b, c>, ... }`.
void append_povray_indices(std::string& text, std::string_view keyword,
                           std::span<const std::array<std::uint32_t, 3>> triangles);

/// Returns unique names of a scene's objects, in the order of `names`: the scene's identifier, `_` and the
/// instance's identifier, numbered if two would be equal.
std::vector<std::string> povray_object_names(std::string_view scene_name, std::span<const std::string> names);

/// Returns the `camera { ... }` of a picture of camera.width by camera.height. World and camera are magnified
/// by `scale` (> 0). The direction through the centre of pixel (i, j) is
///     direction + ((i+1/2)/width - 1/2) right + (1/2 - (j+1/2)/height) up.
///
/// errors    eye at the target; non-finite numbers; field of view outside (0, pi); no pixels.
Result<std::string> povray_camera(const Camera& camera, double scale = 1);

/// Writes the environment as `<stem>_environment.exr` into the folder (half floats, clamped to 65000).
/// Returns the `sky_sphere` that displays it, guarded by the switches above. Without an environment: a black
/// background and no file.
Result<std::string> write_background(const std::filesystem::path& folder, const std::string& stem,
                                     const BackgroundDescription& background);

/// Returns 2^k by which the mesh must be magnified so that POV-Ray interpolates over its triangles: the
/// shortest edge becomes 0.1 and the smallest area 0.005, unless the coordinates are too large.
///
/// POV-Ray 3.7 loses the barycentric weights of triangles with edges below about 0.1 units, and rays longer
/// than 1e7 units. A power of two is lossless.
double small_triangle_scale(const Mesh& mesh);

/// Returns a rotation R for a mesh over which POV-Ray interpolates colours. Write R v for each vertex v, and
/// `matrix <R, 0,0,0>`, row by row, after the mesh, which reverses the rotation.
///
/// POV-Ray 3.7 computes barycentric weights in the projection of a triangle along z, however narrow it is,
/// unless it vanishes. Triangles almost parallel to z, which occur in surfaces extruded along z, get wrong
/// colours. The rotation of a mesh with such triangles maximizes the smallest angle between z and a triangle.
Rotation interpolation_rotation(const Mesh& mesh);

/// True if a triangle is too narrow for POV-Ray to interpolate over, even magnified by `scale`. Such a
/// triangle needs a single texture; otherwise its colours are wrong.
bool is_sliver(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle, double scale);

/// Checks that POV-Ray can display a mesh. POV-Ray accepts non-finite positions but displays nothing.
///
/// where     the beginning of error messages.
/// errors    positions that are not finite or beyond 1e6 m; no triangle; an index out of range.
Result<Done> check_povray_mesh(const Mesh& mesh, const std::string& where);

/// Checks that POV-Ray can display an instance at its placement.
///
/// errors    a translation that is not finite or beyond 1e6 m; a scale outside (0, 1e6]; a rotation that is
///           not finite.
Result<Done> check_placement(const std::string& where, const Placement& placement);

}  // namespace haarfield
