#pragma once
/// The appearance of a surface: its material and its image.

#include "fields/mesh/mesh.h"
#include "scenes/reflection.h"
#include "scenes/texture.h"
#include "shading/scene/emitter.h"
#include "shading/scene/material.h"
#include "shading/walk/outgoing.h"

#include <span>

namespace haarfield {

/// A material with an image. With the image's colour T at a point, outgoing radiance is
///     T (diffuse + emission + ambient + tinted_specular * specular) + (1 - tinted_specular) * specular,
/// where diffuse and specular are the material's reflected radiance. Vertex colours, if used, multiply T.
/// Radiance is computed at vertices; T is evaluated per pixel.
struct Surface {
    Material material;
    Rgb emission{0, 0, 0};                   ///< Emitted radiance; see emitters_of. >= 0. [W/(m^2 sr)]
    Rgb ambient{0, 0, 0};                    ///< Additional radiance that lights nothing. >= 0. [W/(m^2 sr)]
    std::shared_ptr<const Texture> texture;  ///< Null: white.
    bool coloured = false;                   ///< Vertex colours are used.
    Reflection reflection{};                 ///< Not baked; `metallic` has been applied to its colours.
    float tinted_specular = 0;               ///< Fraction of specular light that has the base colour, as on
                                             ///< metals, in [0, 1].

    /// True if outgoing radiance is the material's reflected radiance alone.
    bool is_plain() const { return !texture && !coloured && own_radiance() == Rgb(0.0f); }
    bool emits() const { return emission != Rgb(0.0f); }     ///< True if the surface emits light.
    Rgb own_radiance() const { return emission + ambient; }  ///< Radiance without any light.
    /// True if specular radiance must be known separately.
    bool has_separate_specular() const {
        return (texture || coloured) && material.specular != Rgb(0.0f) && tinted_specular < 1;
    }
};

/// Converts a file's material to the povray convention, so that POV-Ray's ray tracer renders the same:
///
/// phong      diffuse = Kd, POV-Ray's `specular` = Ks with the exponent Ns (roughness 1 / Ns).
/// metallic   diffuse = base (1 - metallic). POV-Ray's `phong` has the exponent n = (2 / roughness^4 - 2) /
///            4. Its weight is (n + 2) / 2 times the reflectance at normal incidence, 0.04 (1 - metallic) +
///            base * metallic; that is the energy of a normalised lobe. Where n is below 1 the lobe is nearly
///            diffuse and is added to diffuse.
/// by_colour  diffuse = 1, to be multiplied by the vertices' colours.
/// none       Material's own defaults.
///
/// Exponents are clamped to [1, 1000] (metallic) and [1, 2000] (phong).
Surface surface_of(const MeshMaterial& material);

/// The displayed radiance of vertices, in two layers. Textures multiply `textured`; `added` is then added
/// unchanged. Without a texture, `textured` is the total.
struct LayeredRadiance {
    std::vector<Rgb> textured;
    std::vector<Rgb> added;  ///< One per vertex; empty if no surface needs it.
};

/// Splits radiance into the factor of the textures and the summand on top of them.
///
/// surfaces  by the material indices of the mesh.
/// radiance  of the vertices, without textures.
LayeredRadiance layered_radiance(const Mesh& mesh, std::span<const Surface> surfaces,
                                 std::span<const Outgoing> radiance);

/// Multiplies the tinted fraction of specular radiance by the colours of the vertices. Images count as white.
std::vector<Rgb> tinted_specular_light(const Mesh& mesh, std::span<const Surface> surfaces,
                                       std::span<const Rgb> highlights);

/// Returns the factors on diffuse reflection by vertex: the vertex colour times the mean of the image over
/// adjacent triangles. Empty if no surface has an image or vertex colours.
///
/// cost  seven image lookups per triangle.
std::vector<Rgb> vertex_tints(const Mesh& mesh, std::span<const Surface> surfaces);

/// Returns the emitting triangles of a mesh. Their radiance contains the mean of image and vertex colours
/// over seven points of the triangle.
std::vector<Emitter> emitters_of(const Mesh& mesh, std::span<const Surface> surfaces);

bool has_textures(std::span<const Surface> surfaces);  ///< True if a surface has a texture.
bool any_reflects(std::span<const Surface> surfaces);  ///< True if a surface has a reflection.
bool all_plain(std::span<const Surface> surfaces);     ///< True if every surface is plain.

/// Returns the surfaces' materials.
std::vector<Material> materials_of(std::span<const Surface> surfaces);

}  // namespace haarfield
