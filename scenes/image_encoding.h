#pragma once
/// Encoders of pictures: PNG by libpng, OpenEXR by its own library. The only use of the two.

#include "fields/base/result.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

namespace haarfield {

/// The attribute of EXR files that holds Image::relative_error.
inline constexpr const char* error_attribute = "haarfield:relative_error";

/// Encodes texels of 8 bits, sRGB, as PNG.
///
/// texels    row by row from the top, 3 or 4 channels each (asserted).
/// errors    those of libpng, with an empty `where`.
Result<std::string> encoded_png(std::span<const std::uint8_t> texels, int width, int height);

/// Encodes linear RGB texels of 16 bits as PNG.
Result<std::string> encoded_png(std::span<const std::uint16_t> texels, int width, int height);

/// Lossless compressions of OpenEXR. `piz` takes a ninth of the time of `zip` for a noisy environment of
/// 8192 x 4096 texels (0.8 s against 7 s) and 5 % fewer bytes.
enum class ExrCompression { zip, piz };

/// Encodes linear texels as OpenEXR with half floats. Equal pictures give equal bytes.
///
/// fill      called for each row from the top, with width * channels values to set, which must be within the
///           range of half floats.
/// channels  3 or 4 (asserted).
/// errors    those of OpenEXR, with an empty `where`.
Result<std::string> encoded_exr(const std::function<void(int row, std::span<float> values)>& fill, int width,
                                int height, std::size_t channels, std::optional<float> relative_error,
                                ExrCompression compression);

}  // namespace haarfield
