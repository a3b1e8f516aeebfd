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

/// The sky as light: an image without the sun, width even, height = width / 2, and the sun's disc beside it.
///
/// Radiance is scaled so that a white horizontal surface under the whole upper half, sun included, reflects a
/// radiance whose luminance is 1. The sun sheds what the paper's air lets through, whatever its angular
/// radius; of a disc that the horizon cuts only the part above it sheds light. The ground reflects all of
/// that diffusely.
///
/// cost  some 0.1 s for 1024 x 512 pixels, one thread.
Environment sky_environment(const AnalyticSky& sky, int width);

/// The same as one image, with the sun spread over the pixels that it covers, its energy exact; where the
/// horizon cuts its disc, the part below is missing. Scaled by what its own pixels shed.
LatLongImage sky_image(const AnalyticSky& sky, int width);

}  // namespace haarfield
