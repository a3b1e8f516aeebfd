#pragma once
/// The encoding of colours on screens and in 8 bit image files: IEC 61966-2-1.

namespace haarfield {

/// sRGB encoding of a linear value, both in [0, 1] (clamped; NaN becomes 0).
float srgb_encoded(float linear);

/// The inverse.
float srgb_decoded(float encoded);

}  // namespace haarfield
