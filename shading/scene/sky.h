#pragma once
/// The analytic sky.

#include "shading/scene/environment.h"

namespace haarfield {

/// The model of Preetham, Shirley and Smits 1999, *A Practical Analytic Model for Daylight*, with a sun disc.
struct AnalyticSky {
    float turbidity = 3;                  ///< 2 (clear) to 10 (hazy).
    float sun_elevation = 0.6981317f;     ///< Above the horizon, 0 to pi/2. [rad]
    float sun_azimuth = 0.7853982f;       ///< From +x towards +z. [rad]
    float sun_angular_radius = 0.00465f;  ///< Half the sun's apparent size; up to 0.1. [rad]
    Rgb ground{0.1f, 0.1f, 0.1f};         ///< Albedo of the ground, which fills the lower half.
};

/// Computes the sky as an image without the sun, and the sun as a disc. width is even, height = width / 2.
///
/// Radiance is scaled so that a white horizontal surface under the whole upper half, sun included, reflects
/// radiance of luminance 1. The sun's irradiance is what the paper's atmosphere transmits, for any angular
/// radius. If the horizon cuts the disc, only the fraction above it emits light. The ground reflects the sum
/// diffusely.
///
/// cost  about 0.1 s for 1024 x 512 pixels, one thread.
Environment sky_environment(const AnalyticSky& sky, int width);

/// Computes the sky as one image, with the sun spread over the pixels that it covers. The sun's energy is
/// exact; where the horizon cuts its disc, the fraction below is missing. Scaled by the irradiance of its
/// pixels.
LatLongImage sky_image(const AnalyticSky& sky, int width);

}  // namespace haarfield
