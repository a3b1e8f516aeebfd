#pragma once
/// Light over images for triangles that may have but one texture: POV-Ray multiplies the one with the other.

#include "bridge/povray/povray_frame.h"
#include "bridge/povray/texture_files.h"
#include "bridge/povray/triangle_atlas.h"

namespace haarfield {

/// Some triangles of a mesh, whose light lies in an atlas, and so does where their corners are in their
/// images: of the two, a function for each channel makes the product at every pixel.
///
/// That takes half again as long to trace as a texture for each light, and 30 % less memory, at 1,800,000
/// vertices; and a ray that goes through such triangles goes on as one ray, where it would as three.
class MappedLight {
public:
    /// mesh        with uvs (asserted).
    /// triangles   which of the mesh's, at least one (asserted).
    /// under       by vertex: what images multiply; where there is no image, all of the light.
    /// over        by vertex: what is added; or none.
    /// object      what names begin with; OBJECT_Finish is declared.
    /// stem        of the atlases' files.
    /// accuracy    places in an image are exact to a 2^17th of one tile plus twice what the largest triangle
    ///             spans; light is half floats, up to 32,500 (of more, too little between the corners).
    MappedLight(const Mesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Colour> under,
                std::span<const Colour> over, const std::string& object, const std::string& stem);

    /// What has to stand before the mesh.
    const std::string& declarations() const { return declarations_; }

    /// The texture of triangles with an image; null: without one.
    std::string texture(const TextureFile* image) const;

    /// Of the corners of the k-th triangle.
    std::array<Vec2f, 3> uvs(std::size_t k) const { return atlas_.uvs(k); }

    /// Writes the atlases: `STEM.exr`, light; `STEM.over.exr`, what is added, if anything is;
    /// `STEM.places.png`, places in images.
    Result<Done> write(const std::filesystem::path& folder) const;

private:
    TriangleAtlas atlas_;
    std::string object_, stem_, declarations_;
    Image light_, over_;  ///< `over_` is empty if nothing is added.
    float most_ = 0;      ///< No channel is brighter.
    std::vector<std::array<std::uint16_t, 3>> places_;
};

}  // namespace haarfield
