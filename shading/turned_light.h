#pragma once
/// Light that turns from frame to frame.

#include <stop_token>

#include "fields/rotation.h"
#include "shading/environment.h"

namespace haarfield {

/// Radiance on a cubemap of twice the resolution that it is wanted in. [W/(m^2 sr)]
struct TurnableLight {
    int face_size = 64;         ///< Of the lighting that is made from it.
    std::vector<Rgb> radiance;  ///< 6 * (2 face_size)^2, face by face; face_size 128 at most.
};

/// cost  that of lighting_texels at twice the size: some 0.2 s for 1024 x 512 pixels.
/// stop  when it is requested, returns soon, and the light is of no use.
TurnableLight turnable_light(const LatLongImage& environment, int face_size,
                             const std::stop_token& stop = {});

/// As lighting_texels of the environment turned by a rotation.
///
/// Each texel is the mean over 4 x 4 places of radiance interpolated between the prefiltered texels.
///
/// accuracy  blurs by about half a texel; the energy of a light of one pixel is kept to some 2 %, or 6 %
/// where
///           it crosses an edge of the cube.
/// cost      16 lookups a texel: some 2 ms on two cores for face size 64.
std::vector<Rgb> turned_lighting_texels(const TurnableLight& light, const Rotation& rotation);

/// The environment turned by a rotation, as an image.
///
/// accuracy  about +y as turned_environment of environment.h; otherwise interpolated between pixels.
/// stop      when it is requested, returns soon, and the image is of no use.
LatLongImage turned_environment(const LatLongImage& image, const Rotation& rotation,
                                const std::stop_token& stop = {});

/// Radiance from a direction (of any length but zero), interpolated between pixels.
Rgb radiance_from(const LatLongImage& image, const Vec3d& direction);

}  // namespace haarfield
