#pragma once
/// Light that rotates from frame to frame.

#include <cstdint>
#include <stop_token>

#include "fields/base/rotation.h"
#include "shading/scene/environment.h"

namespace haarfield {

/// Resampled light: a smooth part to be interpolated, and separately the excess over eight times the mean, so
/// that suns stay small and keep their energy.
struct TurnableLight {
    /// The excess of a texel of the doubled cubemap.
    struct BrightTexel {
        std::uint32_t texel;  ///< Index in `radiance`.
        Rgb light;            ///< As in lighting.h, for lighting of size face_size. [W/m^2]
    };
    int face_size = 64;               ///< Size of the lighting computed from it.
    std::vector<Rgb> radiance;        ///< Smooth part: 6 * (2 face_size)^2, by face. [W/(m^2 sr)]
    std::vector<BrightTexel> bright;  ///< At most an eighth of the texels.
    std::vector<float> solid_angles;  ///< Of one face of the doubled cubemap, times its texels. [sr]
};

/// Computes the light.
///
/// cost  that of lighting_texels at twice the size: about 0.2 s for 1024 x 512 pixels.
/// stop  once requested, returns soon with unspecified light.
TurnableLight turnable_light(const LatLongImage& environment, int face_size,
                             const std::stop_token& stop = {});

/// Returns the lighting_texels of the rotated environment.
///
/// Each texel is the mean over 2 x 2 interpolated samples of the smooth part. Each bright texel is
/// distributed from 4 x 4 points within it.
///
/// accuracy  bright texels keep their energy, and their position to a sixteenth of a texel; the smooth part
///           is blurred by about half a texel. Exact up to rounding for the identity.
/// cost      four lookups per texel, and sixteen per bright texel: about 1.5 ms on one core for face size 64.
std::vector<Rgb> turned_lighting_texels(const TurnableLight& light, const Rotation& rotation);

/// Returns an image of the rotated environment.
///
/// accuracy  about +y as turned_environment of environment.h; otherwise interpolated between pixels.
/// stop      once requested, returns soon with an unspecified image.
LatLongImage turned_environment(const LatLongImage& image, const Rotation& rotation,
                                const std::stop_token& stop = {});

/// Rotates an environment with its discs.
Environment turned_environment(const Environment& environment, const Rotation& rotation,
                               const std::stop_token& stop = {});

}  // namespace haarfield
