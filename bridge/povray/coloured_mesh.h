#pragma once
/// A mesh with a colour at each vertex, in POV-Ray's words.

#include "fields/mesh/mesh.h"
#include "scenes/image.h"

#include <span>
#include <string>

namespace haarfield {

/// How POV-Ray is told the colours. All look the same to the precision of half floats, which is that of its
/// pictures.
enum class ColourStorage {
    textures,       ///< A texture for each colour that occurs: the fastest to read, 860 bytes each.
    grey_textures,  ///< The same for colours without hue, rounded to half floats: a few thousand textures.
    atlas,          ///< TriangleAtlas: a third of the memory, half again the time.
};

inline constexpr std::size_t most_textured_vertices = 1000000;  ///< Of which each may have a texture.

/// The one that suits a mesh of these colours: textures up to 200,000 vertices; above that grey ones if
/// no colour has a hue, and the atlas above most_textured_vertices.
ColourStorage colour_storage(std::span<const Rgb> colours);

/// A coloured mesh in POV-Ray's words.
struct ColouredMesh {
    /// `mesh2 { ... }` without its last brace, in the mesh's frame: transformations may follow.
    std::string text;
    Image atlas;               ///< Empty without one. Texels may be negative; floats, meant for an EXR file.
    std::size_t textures = 0;  ///< How many there are.
    std::uint64_t clamped_vertices = 0;  ///< Colours below 0 or above 65000, set to the limit.
};

/// The text of a mesh whose surface emits its vertices' colours, linear between them.
///
/// finish      the name of a finish to be used: `finish { emission 1 ambient 0 diffuse 0 }`.
/// atlas_file  where POV-Ray will find the atlas, if there is one.
/// colours     one per vertex, finite. [W/(m^2 sr)]
/// cost        0.5 s and some 160 bytes of text per 100,000 vertices; twice that for the atlas.
ColouredMesh coloured_mesh(const Mesh& mesh, std::span<const Rgb> colours, ColourStorage storage,
                           const std::string& finish, const std::string& atlas_file);

}  // namespace haarfield
