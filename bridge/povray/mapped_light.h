#pragma once
/// Combines light with images for triangles that can have only one texture: POV-Ray multiplies the two.

#include "bridge/povray/povray_frame.h"
#include "bridge/povray/texture_files.h"
#include "bridge/povray/triangle_atlas.h"

namespace haarfield {

/// Some triangles of a mesh whose light is stored in an atlas. A second atlas stores the image coordinates of
/// their corners. A function per colour channel multiplies light and image at every pixel.
///
/// Compared with a texture per colour, rendering takes 1.5 times as long and 30 % less memory (1,800,000
/// vertices). A ray that passes through such a triangle continues as one ray instead of three.
class MappedLight {
public:
    /// mesh       has uvs (asserted).
    /// triangles  indices of the triangles, at least one (asserted).
    /// textured   by vertex: the light that images multiply. Without an image, all of the light.
    /// added      by vertex: light that is added after the image; or empty.
    /// object     prefix of all names. OBJECT_Finish must be declared.
    /// stem       stem of the atlas files.
    /// accuracy   image coordinates are exact to 2^-17 of one tile plus twice the extent of the largest
    ///            triangle. Light is stored as half floats. Above 32,500 the interpolation is too dark.
    MappedLight(const Mesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Colour> textured,
                std::span<const Colour> added, const std::string& object, const std::string& stem);

    /// Returns the text that must precede the mesh.
    const std::string& declarations() const { return declarations_; }

    /// Returns the texture of the triangles with an image. Null: of the triangles without one.
    ///
    /// reflection  of their surface; see povray_reflection.
    std::string texture(const TextureFile* image, const Reflection& reflection = {}) const;

    /// Returns the atlas coordinates of the corners of the k-th triangle.
    std::array<Vec2f, 3> uvs(std::size_t k) const { return atlas_.uvs(k); }

    /// Writes the atlases: `STEM.exr`, light; `STEM.over.exr`, added light, if there is any;
    /// `STEM.places.png`, image coordinates.
    Result<Done> write(const std::filesystem::path& folder) const;

private:
    TriangleAtlas atlas_;
    std::string object_, stem_, declarations_;
    Image light_, added_;  ///< `added_` is empty if no light is added.
    float most_ = 0;       ///< Upper bound of all channels.
    std::vector<std::array<std::uint16_t, 3>> places_;
};

}  // namespace haarfield
