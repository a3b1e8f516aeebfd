#pragma once
/// Images on surfaces.

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

/// An image with the colour that multiplies diffuse reflection, and with opacity. It repeats in both
/// directions.
struct Texture {
    std::string name;           ///< The file's name without extension, or the model's name of the image.
    int width = 0, height = 0;  ///< [texels], at least 1.
    /// sRGB and opacity, rows from the top, as in 8 bit PNG files. 255 is opaque.
    std::vector<std::array<std::uint8_t, 4>> texels;
    bool has_alpha = false;  ///< Some texel is not opaque.
    Rgb mean{1.0f};          ///< Mean of all texels, linear.
    std::string jpeg;        ///< The file's bytes if it is an unmodified JPEG; else empty.
    std::string png;         ///< The file's bytes if it is an unmodified PNG, including its alpha if
                             ///< `has_alpha`; else empty.

    /// Returns the linear colour, bilinear between texel centres, as POV-Ray's `interpolate 2`.
    Rgb colour_at(const Vec2f& uv) const;
    float opacity_at(const Vec2f& uv) const;  ///< Bilinear, in [0, 1].

    /// Tests whether a triangle may touch a texel that is not opaque (conservative).
    bool is_cut_out(const std::array<Vec2f, 3>& triangle) const;
};

/// Returns the texture's opacity; empty if it is opaque everywhere.
OpacityMap opacity_map(const Texture& texture);

/// The images that make up a texture.
struct TextureSource {
    MeshImage image, opacity_map;  ///< At least one is present. See MeshMaterial.
    AlphaMode alpha = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;
};

/// Reads a texture. Values are rounded to 8 bits. AlphaMode::mask makes each texel opaque or transparent. An
/// opacity map is resampled to the image's size. An image that would be fully transparent becomes opaque: its
/// alpha channel has another meaning.
///
/// errors  as read_image, for either image.
Result<Texture> read_texture(const TextureSource& source);

/// Returns the mean of an image's channels as stored, without sRGB decoding: for maps that hold numbers.
Result<Rgb> mean_of_numbers(const MeshImage& image);

}  // namespace haarfield
