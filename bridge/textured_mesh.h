#pragma once
/// A mesh with light at each vertex and images over it, in POV-Ray's words.

#include "bridge/coloured_mesh.h"
#include "bridge/texture_files.h"

namespace haarfield {

/// The text of a mesh whose surface emits its vertices' light, linear between them, times its textures'
/// images at every pixel, plus what lies over them. The product is POV-Ray's own, to the precision of its
/// pictures.
///
/// Where an image is not opaque there is no surface. A triangle that touches such texels has one light all
/// over, the mean of its corners': POV-Ray traces a ray through each of the textures of a triangle, three
/// through three, and their number grows threefold with every layer. It also stands off by 0.15 mm, as
/// POV-Ray loses all of a mesh behind two hits that are nearer to each other than 1e-4 units.
///
/// surfaces  by the mesh's materials; where there is a texture the mesh has uvs (asserted).
/// under     one per vertex, finite: what images multiply; where there is no image, all of the light.
/// over      what is added; one per vertex, finite, or none.
/// files     of the textures.
/// finish    the name of a finish to be used: `finish { emission 1 ambient 0 diffuse 0 }`.
/// scale     by which the mesh will be placed in metres.
/// cost      0.7 s and some 220 bytes of text per 100,000 vertices.
ColouredMesh textured_mesh(const Mesh& mesh, std::span<const Surface> surfaces, std::span<const Rgb> under,
                           std::span<const Rgb> over, const TextureFiles& files, const std::string& finish,
                           float scale = 1);

}  // namespace haarfield
