#pragma once
/// The analytic sky, for when there is no photograph.

#include "shading/scene/environment.h"

namespace haarfield {

/// Preetham, Shirley and Smits 1999, *A Practical Analytic Model for Daylight*, with a sun disc.
struct AnalyticSky {
    float turbidity = 3;                  ///< 2 (clear) to 10 (hazy).
    float sun_elevation = 0.6981317f;     ///< Above the horizon, 0 to pi/2. [rad]
    float sun_azimuth = 0.7853982f;       ///< From +x towards +z. [rad]
    float sun_angular_radius = 0.00465f;  ///< Half the sun's apparent size; up to 0.1. [rad]
    Rgb ground{0.1f, 0.1f, 0.1f};         ///< Albedo of the ground, which fills the lower half.
};

/// The sky as a lat-long image; width even, height = width / 2.
///
/// Radiance is scaled so that a white horizontal surface under the image's whole upper half, sun
/// included, reflects a radiance whose luminance is 1. The sun sheds what the paper's air lets through,
/// whatever its angular radius; it is spread over the pixels that it covers, with its energy exact. Where
/// the horizon cuts its disc, the part below is missing. The ground reflects that light diffusely.
///
/// cost  some 0.1 s for 1024 x 512 pixels, one thread.
LatLongImage sky_image(const AnalyticSky& sky, int width);

}  // namespace haarfield
