#pragma once
/// Images over surfaces.

#include "fields/base/result.h"
#include "fields/mesh/mesh_material.h"
#include "fields/preparation/opaque_outline.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace haarfield {

/// What the diffuse term of a surface is multiplied with, and how much of the surface there is. The image
/// repeats in both directions.
struct Texture {
    std::string name;           ///< A file's name without its ending, or what the model calls it.
    int width = 0, height = 0;  ///< [texels], at least 1.
    /// sRGB and opacity, row by row from the top: as 8 bit PNG files have them. 255 is opaque.
    std::vector<std::array<std::uint8_t, 4>> texels;
    bool has_alpha = false;  ///< Some texel is not opaque.
    Rgb mean{1.0f};          ///< Of all texels, linear.
    std::string jpeg;        ///< The file's bytes, if it is a JPEG and nothing of it was changed; else empty.
    std::string png;         ///< Likewise of a PNG; of its alpha, if `has_alpha`, nothing was changed either.

    /// Linear and bilinear between the texels' middles, as POV-Ray's `interpolate 2` has it.
    Rgb colour_at(const Vec2f& uv) const;
    float opacity_at(const Vec2f& uv) const;  ///< Likewise, in [0, 1].

    /// Whether a texel is not opaque that touches a triangle, or nearly.
    bool is_cut_out(const std::array<Vec2f, 3>& triangle) const;
};

/// How opaque it is; no map if it is opaque everywhere.
OpacityMap opacity_map(const Texture& texture);

/// How a texture is put together.
struct TextureSource {
    MeshImage image, opacity_map;  ///< One of them is there. See MeshMaterial.
    AlphaMode alpha = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;
};

/// Reads a texture. Finer than 8 bits is rounded, floating point taken as linear. With AlphaMode::mask texels
/// are wholly there or not at all. An opacity map is resampled to the image's size. An alpha channel that
/// leaves nothing is taken for something else, and all texels are opaque.
///
/// errors  as read_image, of either image.
Result<Texture> read_texture(const TextureSource& source);

/// Mean of an image's linear channels, without sRGB decoding: for maps that hold numbers.
Result<Rgb> mean_of_numbers(const MeshImage& image);

}  // namespace haarfield
