#pragma once
/// Writes a mesh with light at each vertex and images in POV-Ray's language.

#include "bridge/povray/coloured_mesh.h"
#include "bridge/povray/mapped_light.h"

#include <optional>

namespace haarfield {

/// A textured mesh in POV-Ray's language.
struct TexturedMesh {
    std::string text;                    ///< As in ColouredMesh.
    std::optional<MappedLight> mapped;   ///< To be declared before the text, and written next to it.
    std::size_t textures = 0;            ///< The number of textures.
    std::uint64_t clamped_vertices = 0;  ///< As in ColouredMesh.
};

/// True if the light of all triangles should be stored in images: for more than most_textured_vertices, or
/// for more than 100,000 vertices with specular light, which would take two textures per vertex.
bool maps_light(std::span<const Rgb> textured, std::span<const Rgb> added);

/// Returns the text of a mesh whose surface emits the light of its vertices, interpolated linearly, times its
/// images at every pixel, plus specular light. POV-Ray computes the product, within the precision of its
/// pictures.
///
/// Transparent texels have no surface. A triangle that touches such texels stores its light in an image too
/// (MappedLight), because POV-Ray traces one ray through each of a triangle's textures. With three textures,
/// the number of rays would triple with every layer. The triangle is also moved outwards by 0.15 mm, because
/// POV-Ray loses the whole mesh behind two hits that are closer than 1e-4 units. A triangle that covers more
/// texels than its coordinates can resolve (8,192) has constant light in that case, as slivers always have.
///
/// A triangle with a reflection stores its light in an image for the same reason. Without a fitting image
/// coordinate (see above), it has no reflection.
///
/// surfaces  by the mesh's materials. With a texture, the mesh has uvs (asserted).
/// textured  one per vertex, finite: the light that images multiply. Without an image, all of the light.
/// added     specular light that is added; one per vertex, finite, or none.
/// files     the files of the textures.
/// maps_all  true: the light of all triangles is stored in images; see maps_light.
/// object    prefix of all names. OBJECT_Finish must be declared: `finish { emission 1 ambient 0 diffuse 0
///           }`.
/// stem      stem of MappedLight's files.
/// scale     the scale of the mesh's placement in metres.
/// cost      0.7 s and about 220 bytes of text per 100,000 vertices.
TexturedMesh textured_mesh(const Mesh& mesh, std::span<const Surface> surfaces, std::span<const Rgb> textured,
                           std::span<const Rgb> added, const TextureFiles& files, bool maps_all,
                           const std::string& object, const std::string& stem, float scale = 1);

}  // namespace haarfield
