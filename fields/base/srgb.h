#pragma once
/// The encoding of colours on screens and in 8 bit image files: IEC 61966-2-1.

#include <algorithm>
#include <cstdint>

namespace haarfield {

/// sRGB encoding of a linear value, both in [0, 1] (clamped; NaN becomes 0).
float srgb_encoded(float linear);

/// The inverse.
float srgb_decoded(float encoded);

/// A number in [0, 1] (clamped) as a byte, to the nearest.
inline std::uint8_t unit_byte(float number) {
    return static_cast<std::uint8_t>(std::clamp(number, 0.0f, 1.0f) * 255.0f + 0.5f);
}

}  // namespace haarfield
