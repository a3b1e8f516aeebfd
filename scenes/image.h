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

/// A linear RGB picture with coverage. Where there is coverage the radiance is premultiplied by it, as
/// OpenEXR and POV-Ray have it: what the objects add to the pixel, background left out.
struct Image {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;      ///< Row by row from the top, width * height; linear radiance.
    std::vector<float> coverage;  ///< 0 background to 1 object, per pixel; empty if there is no alpha.
    /// What its maker estimates its own error to be: RMS of the error / RMS of the radiance, over the
    /// objects.
    std::optional<float> relative_error = std::nullopt;
};

/// Reads image_formats (image_format.h), whatever the file is called; in a reader process if there is one.
///
/// radiance  8 and 16 bit integers are taken as sRGB, floating point as linear; grey becomes three equal
///           channels. Nothing is multiplied by alpha or divided by it: the file's numbers are kept.
/// coverage  from the alpha channel, clamped to [0, 1].
/// errors    those of InputFile::open; no image of these, cut short, larger than 2^28 pixels (2^24 in next to
///           nothing).
Result<Image> read_image(const std::filesystem::path& file);

/// The same of an image file's bytes, as models embed them.
///
/// where   what messages call it.
Result<Image> read_image_bytes(std::string_view bytes, const std::string& where);

/// Writes an image by the file's ending; anything but .exr and .png is an error.
///
/// .exr      linear, half floats, with alpha if there is coverage. Radiance beyond 65000 is clamped.
///           relative_error becomes an attribute of the file, and read_image finds it again.
/// .png      8 bit, sRGB-encoded, clamped to [0, 1]; alpha is left out: see over().
/// atomic    as write_file: never half a file.
/// errors    non-finite radiance or coverage; what the disk says.
Result<Done> write_image(const Image& image, const std::filesystem::path& file);

/// The bytes of a PNG: 8 bit sRGB. With coverage it has alpha, not premultiplied, as PNG wants it.
///
/// errors    non-finite radiance or coverage; an empty image.
Result<std::string> png_bytes(const Image& image);

/// The bytes of a PNG of texels as they are: sRGB, and alpha that is not premultiplied.
///
/// texels      row by row from the top, width * height (asserted).
/// with_alpha  whether to write the fourth channel.
Result<std::string> png_bytes(std::span<const std::array<std::uint8_t, 4>> texels, int width, int height,
                              bool with_alpha);

/// The bytes of a PNG of numbers, three a texel, as they are: 16 bit, linear.
///
/// texels  as above.
Result<std::string> png_bytes(std::span<const std::array<std::uint16_t, 3>> texels, int width, int height);

/// The image in front of a background of the same size (asserted); without coverage, the image itself.
Image over(const Image& image, const Image& background);

/// How much of a picture 8 bits can not show: of the pixels that objects cover by half or more, the share in
/// which these shine brighter than 1 in a channel. Without coverage, of all pixels; 0 if there are none.
double clipped_share(const Image& image);

/// Reads a lat-long environment as it is: neither cleaned nor turned.
///
/// errors    as read_image; a width that is not twice the height.
Result<LatLongImage> read_environment_image(const std::filesystem::path& file);

}  // namespace haarfield
