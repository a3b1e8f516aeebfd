#pragma once
/// How a surface answers light.

#include "fields/vector.h"

#include <cstdint>

namespace haarfield {

/// How the specular lobe is meant.
enum class LobeConvention : std::uint8_t {
    /// Energy-normalised and cosine-weighted:
    ///     outgoing = int L [ diffuse/pi + specular (n+2)/(2 pi) max(0,R.w)^n ] max(0,N.w) dw
    physical,
    /// POV-Ray's `phong` under a light source of radiance * solid angle / pi: no cosine on the
    /// highlight, but nothing from below the horizon:
    ///     outgoing = int L [ diffuse/pi max(0,N.w) + specular/pi max(0,R.w)^n [N.w > 0] ] dw
    povray,
};

/// A diffuse (Lambertian) and a specular (Phong) term. R is the view direction mirrored about N.
struct Material {
    Rgb diffuse{0.5f, 0.5f, 0.5f};  ///< Albedo, each channel in [0, 1].
    Rgb specular{0, 0, 0};          ///< Each channel in [0, 1].
    float shininess = 50;           ///< Exponent n, 1 to 1000.
    LobeConvention convention = LobeConvention::physical;
};

}  // namespace haarfield
