#pragma once
/// Writes a mesh with a colour at each vertex in POV-Ray's language.

#include "fields/mesh/mesh.h"
#include "scenes/image.h"
#include "scenes/surface.h"

#include <span>
#include <string>

namespace haarfield {

/// The method that stores colours for POV-Ray. All methods look the same within the precision of half floats,
/// which is that of POV-Ray's pictures.
enum class ColourStorage {
    textures,       ///< A texture for each distinct colour: the fastest to parse, 860 bytes each.
    grey_textures,  ///< Textures of grey colours, rounded to half floats: at most a few thousand.
    atlas,          ///< A TriangleAtlas: a third of the memory, 1.5 times the render time.
};

/// The most vertices that may have a texture each.
inline constexpr std::size_t most_textured_vertices = 1000000;

/// Returns the storage that suits the colours of a mesh: textures for up to 200,000 vertices; for larger
/// meshes grey textures if no colour has a hue, and the atlas above most_textured_vertices.
ColourStorage colour_storage(std::span<const Rgb> colours);

/// A coloured mesh in POV-Ray's language.
struct ColouredMesh {
    /// `mesh2 { ... }` without its last brace, in the mesh's frame. Transformations may follow.
    std::string text;
    Image atlas;  ///< Empty for other storage. Texels may be negative and must be stored as floats (EXR).
    std::size_t textures = 0;            ///< The number of textures.
    std::uint64_t clamped_vertices = 0;  ///< Vertices with colours below 0 or above 65000, which are clamped.
};

/// Returns the text of a mesh whose surface emits the colours of its vertices, interpolated linearly.
///
/// finish      the name of the finish: `finish { emission 1 ambient 0 diffuse 0 }`.
/// atlas_file  the file of the atlas, if one is used, as POV-Ray is to find it.
/// colours     one per vertex, finite. [W/(m^2 sr)]
/// surfaces    by the mesh's materials, with their reflections; or none. With reflections, `storage` is an
///             atlas (asserted): POV-Ray traces a reflected ray for each texture of a triangle.
/// cost        0.5 s and about 160 bytes of text per 100,000 vertices; twice that with an atlas.
ColouredMesh coloured_mesh(const Mesh& mesh, std::span<const Rgb> colours, ColourStorage storage,
                           const std::string& finish, const std::string& atlas_file,
                           std::span<const Surface> surfaces = {});

}  // namespace haarfield
