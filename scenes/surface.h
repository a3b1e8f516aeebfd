#pragma once
/// How a surface looks: how it answers light, and what image lies over it.

#include "fields/mesh/mesh.h"
#include "scenes/texture.h"
#include "shading/scene/emitter.h"
#include "shading/scene/material.h"
#include "shading/scene/outgoing.h"

#include <span>

namespace haarfield {

/// A material of a scene.
///
/// Under what the material makes of light lies an image: with its colour T at a point, the point's outgoing
/// radiance is
///     T (diffuse + emission + tinted_highlights * highlights) + (1 - tinted_highlights) * highlights.
/// Colours of vertices, if they are used, multiply T. Light is computed at the vertices; T is looked up at
/// each pixel.
struct Surface {
    Material material;
    Rgb emission{0, 0, 0};                   ///< Radiance of its own; see emitters_of. >= 0. [W/(m^2 sr)]
    std::shared_ptr<const Texture> texture;  ///< Null: white.
    bool coloured = false;                   ///< Whether colours of vertices are used.
    float tinted_highlights = 0;             ///< The share of a metal's, in [0, 1].

    /// Whether radiance is what the material makes of light, and nothing else.
    bool is_plain() const { return !texture && !coloured && emission == Rgb(0.0f); }
    bool glows() const { return emission != Rgb(0.0f); }  ///< Whether it has light of its own.
    /// Whether its highlights must be known apart.
    bool parts_highlights() const {
        return (texture || coloured) && material.specular != Rgb(0.0f) && tinted_highlights < 1;
    }
};

/// A file's material as haarfield computes it, in the povray convention, so that POV-Ray's ray tracer shows
/// the same:
///
/// phong      diffuse = Kd, POV-Ray's `specular` = Ks with the exponent Ns (roughness 1 / Ns).
/// metallic   diffuse = base (1 - metallic), POV-Ray's `phong` with the exponent n = (2 / roughness^4 - 2) /
///            4 and the weight (n + 2) / 2 of the reflectance at normal incidence, 0.04 (1 - metallic) + base
///            * metallic. That is the energy of a normalised lobe. Where n is below 1 the highlight is as
///            good as diffuse, and is added there.
/// by_colour  diffuse = 1, to be multiplied with the vertices' colours.
/// none       Material's own defaults.
///
/// Exponents are clamped to [1, 1000] and [1, 2000].
Surface surface_of(const MeshMaterial& material);

/// What is seen of a mesh: radiance at its vertices, to be multiplied with the surfaces' textures, and what
/// comes on top. Where there is no texture all is in `under`.
struct SeenRadiance {
    std::vector<Rgb> under;
    std::vector<Rgb> over;  ///< As many, or none if there is nothing.
};

/// Splits radiance into the factor of the textures and the summand on top of them.
///
/// surfaces  by the material indices of the mesh.
/// radiance  of the vertices, without textures.
SeenRadiance seen_radiance(const Mesh& mesh, std::span<const Surface> surfaces,
                           std::span<const Outgoing> radiance);

/// Multiplies the tinted fraction of specular radiance by the colours of the vertices. Images count as white.
std::vector<Rgb> seen_highlights(const Mesh& mesh, std::span<const Surface> surfaces,
                                 std::span<const Rgb> highlights);

/// What the surfaces multiply the diffuse term with, by vertex: its colour, and the mean of the image over
/// the triangles round it. None if all is white.
///
/// cost  seven looks into the image a triangle.
std::vector<Rgb> vertex_tints(const Mesh& mesh, std::span<const Surface> surfaces);

/// What of a mesh glows, triangle by triangle: with the mean of its image, at seven places of each triangle,
/// and of its vertices' colours.
std::vector<Emitter> emitters_of(const Mesh& mesh, std::span<const Surface> surfaces);

bool has_textures(std::span<const Surface> surfaces);  ///< Whether one of them has a texture.
bool all_plain(std::span<const Surface> surfaces);     ///< Whether each of them is.

/// The surfaces' materials.
std::vector<Material> materials_of(std::span<const Surface> surfaces);

}  // namespace haarfield
