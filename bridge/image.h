#pragma once
/// Pictures in memory and on disk. The one place that knows image files (OpenImageIO).

#include "fields/result.h"
#include "fields/vector.h"
#include "shading/environment.h"

#include <filesystem>
#include <vector>

namespace haarfield {

/// A linear RGB picture with coverage.
struct Image {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;      ///< Row by row from the top; linear radiance.
    std::vector<float> coverage;  ///< 0 background to 1 object, per pixel; empty if the file has none.
};

/// Reads any format that OpenImageIO knows; 8 and 16 bit formats are taken as sRGB, float as linear.
Result<Image> read_image(const std::filesystem::path& file);

/// Writes linear half-float EXR, or 8-bit sRGB PNG clamped to [0, 1], by the file's ending; atomically.
Result<Done> write_image(const Image& image, const std::filesystem::path& file);

/// sRGB encoding of a linear value, both in [0, 1] (clamped).
float srgb_encoded(float linear);

/// Reads a lat-long environment as it is: neither cleaned nor turned. Width must be twice the height.
Result<LatLongImage> read_environment_image(const std::filesystem::path& file);

}  // namespace haarfield
