#pragma once
/// Pictures in memory and on disk.

#include "fields/base/result.h"
#include "fields/base/srgb.h"
#include "fields/base/vector.h"
#include "shading/scene/environment.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// A linear RGB image with coverage. Pixels are premultiplied by coverage, as in OpenEXR and POV-Ray: they
/// hold the radiance that objects add, without the background.
struct Image {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;      ///< Rows from the top, width * height; linear radiance.
    std::vector<float> coverage;  ///< Per pixel from 0 (background) to 1 (object); empty without alpha.
    /// The error that the renderer estimates for its own image: RMS of the error / RMS of the radiance, over
    /// pixels with objects.
    std::optional<float> relative_error = std::nullopt;
};

/// Reads an image of any of image_formats (image_format.h), detected from its content. Decodes in the reader
/// process if there is one.
///
/// radiance  8 and 16 bit integers are decoded from sRGB, floating point is linear; grey becomes three equal
///           channels. Values are neither multiplied nor divided by alpha.
/// coverage  from the alpha channel, clamped to [0, 1].
/// errors    those of InputFile::open; other formats; truncated files; more than 2^28 pixels; more than 2^24
///           pixels in a file that is too small for them.
Result<Image> read_image(const std::filesystem::path& file);

/// Decodes the bytes of an image file, such as models embed; as read_image.
///
/// where   the name of the image in messages.
Result<Image> read_image_bytes(std::string_view bytes, const std::string& where);

/// Writes an image in the format of the file's extension: .exr or .png, else an error.
///
/// .exr      linear, half floats, with alpha if there is coverage. Radiance is clamped to +-65000.
///           relative_error becomes an attribute of the file, which read_image reads.
/// .png      8 bit, sRGB-encoded, clamped to [0, 1], without alpha: see over().
/// atomic    as write_file: no partial file is ever visible.
/// errors    an empty image; non-finite radiance or coverage; errors of the file system.
Result<Done> write_image(const Image& image, const std::filesystem::path& file);

/// Writes an environment as .exr, as write_image does, but with PIZ compression, which is faster for noisy
/// images, and without a copy of its pixels.
///
/// errors    those of write_image.
Result<Done> write_environment_image(const LatLongImage& image, const std::filesystem::path& file);

/// Returns the bytes of a PNG: 8 bit sRGB. With coverage it has an alpha channel, not premultiplied, as PNG
/// requires.
///
/// errors    non-finite radiance or coverage; an empty image.
Result<std::string> png_bytes(const Image& image);

/// Returns the bytes of a PNG of sRGB texels with alpha that is not premultiplied. Texels are stored
/// unchanged.
///
/// texels      rows from the top, width * height (asserted).
/// with_alpha  true: writes the fourth channel.
Result<std::string> png_bytes(std::span<const std::array<std::uint8_t, 4>> texels, int width, int height,
                              bool with_alpha);

/// Returns the bytes of a PNG of 16 bit linear numbers, three per texel, stored unchanged.
///
/// texels  as above.
Result<std::string> png_bytes(std::span<const std::array<std::uint16_t, 3>> texels, int width, int height);

/// Composites the image over a background of the same size (asserted). Without coverage, returns the image.
Image over(const Image& image, const Image& background);

/// Returns the fraction of pixels that clip in 8 bits: those brighter than 1 in a channel, of the pixels that
/// objects cover by at least half. Radiance is divided by coverage first. Without coverage, all pixels count;
/// 0 if no pixel counts.
double clipped_share(const Image& image);

/// Reads a lat-long environment; neither cleans nor rotates it.
///
/// errors    as read_image; a width that is not twice the height.
Result<LatLongImage> read_environment_image(const std::filesystem::path& file);

}  // namespace haarfield
