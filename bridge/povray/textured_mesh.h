#pragma once
/// A mesh with light at each vertex and images over it, in POV-Ray's words.

#include "bridge/povray/coloured_mesh.h"
#include "bridge/povray/mapped_light.h"

#include <optional>

namespace haarfield {

/// A textured mesh in POV-Ray's words.
struct TexturedMesh {
    std::string text;                    ///< As of ColouredMesh.
    std::optional<MappedLight> mapped;   ///< Declared before the text, written beside it.
    std::size_t textures = 0;            ///< How many there are.
    std::uint64_t clamped_vertices = 0;  ///< As of ColouredMesh.
};

/// Whether the light of all triangles suits images: of more than most_textured_vertices, or of more than
/// 100,000 with highlights, which would take two textures a vertex.
bool maps_light(std::span<const Rgb> under, std::span<const Rgb> over);

/// The text of a mesh whose surface emits its vertices' light, linear between them, times its textures'
/// images at every pixel, plus what lies over them. The product is POV-Ray's own, to the precision of its
/// pictures.
///
/// Where an image is not opaque there is no surface. A triangle that touches such texels has its light in an
/// image, too (MappedLight): POV-Ray traces a ray through each of the textures of a triangle, three through
/// three, and their number grows threefold with every layer. It also stands off by 0.15 mm, as POV-Ray loses
/// all of a mesh behind two hits that are nearer to each other than 1e-4 units. A triangle over more texels
/// than its place can be told by (8,192) has one light for all of it there, as slivers have anywhere.
///
/// surfaces  by the mesh's materials; where there is a texture the mesh has uvs (asserted).
/// under     one per vertex, finite: what images multiply; where there is no image, all of the light.
/// over      what is added; one per vertex, finite, or none.
/// files     of the textures.
/// maps_all  whether the light of all triangles lies in images: see maps_light.
/// object    what names begin with; OBJECT_Finish is declared: `finish { emission 1 ambient 0 diffuse 0 }`.
/// stem      of the files of MappedLight.
/// scale     by which the mesh will be placed in metres.
/// cost      0.7 s and some 220 bytes of text per 100,000 vertices.
TexturedMesh textured_mesh(const Mesh& mesh, std::span<const Surface> surfaces, std::span<const Rgb> under,
                           std::span<const Rgb> over, const TextureFiles& files, bool maps_all,
                           const std::string& object, const std::string& stem, float scale = 1);

}  // namespace haarfield
