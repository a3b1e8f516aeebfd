#pragma once
/// Light that turns from frame to frame.

#include <cstdint>
#include <stop_token>

#include "fields/base/rotation.h"
#include "shading/scene/environment.h"

namespace haarfield {

/// Light that can be resampled: an even part to be interpolated, and what is brighter than eight times the
/// mean by itself, so that suns stay small and keep their energy.
struct TurnableLight {
    /// What a texel of the doubled cubemap has more than that.
    struct BrightTexel {
        std::uint32_t texel;  ///< In `radiance`.
        Rgb light;            ///< lighting.h, for lighting of size face_size. [W/m^2]
    };
    int face_size = 64;               ///< Of the lighting that is made from it.
    std::vector<Rgb> radiance;        ///< The even part: 6 * (2 face_size)^2, face by face. [W/(m^2 sr)]
    std::vector<BrightTexel> bright;  ///< An eighth of the texels at most.
    std::vector<float> solid_angles;  ///< Of one face of the doubled cubemap, times its texels. [sr]
};

/// cost  that of lighting_texels at twice the size: some 0.2 s for 1024 x 512 pixels.
/// stop  when it is requested, returns soon, and the light is of no use.
TurnableLight turnable_light(const LatLongImage& environment, int face_size,
                             const std::stop_token& stop = {});

/// As lighting_texels of the environment turned by a rotation.
///
/// Each texel is the mean over 2 x 2 places of the even part, interpolated; each bright texel is dealt out
/// from 4 x 4 places in it.
///
/// accuracy  what is bright keeps its energy, and its place to a sixteenth of a texel; the even part is
///           blurred by about half a texel. Exact up to rounding if the rotation turns nothing.
/// cost      four lookups a texel, and sixteen a bright texel: some 1.5 ms on one core for face size 64.
std::vector<Rgb> turned_lighting_texels(const TurnableLight& light, const Rotation& rotation);

/// The environment turned by a rotation, as an image.
///
/// accuracy  about +y as turned_environment of environment.h; otherwise interpolated between pixels.
/// stop      when it is requested, returns soon, and the image is of no use.
LatLongImage turned_environment(const LatLongImage& image, const Rotation& rotation,
                                const std::stop_token& stop = {});

/// The same with its discs.
Environment turned_environment(const Environment& environment, const Rotation& rotation,
                               const std::stop_token& stop = {});

}  // namespace haarfield
