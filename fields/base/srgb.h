#pragma once
/// Encoding of colours on screens and in 8 bit image files: sRGB (IEC 61966-2-1).

#include <algorithm>
#include <cstdint>

namespace haarfield {

/// Returns the sRGB encoding of a linear value, both in [0, 1] (clamped; NaN becomes 0).
float srgb_encoded(float linear);

/// The inverse of srgb_encoded.
float srgb_decoded(float encoded);

/// Rounds a number in [0, 1] (clamped) to a byte.
inline std::uint8_t unit_byte(float number) {
    return static_cast<std::uint8_t>(std::clamp(number, 0.0f, 1.0f) * 255.0f + 0.5f);
}

}  // namespace haarfield
