#pragma once
/// Distant light: a lat-long image of incident radiance, where it comes from and how it is cleaned.

#include "fields/wavelets/cubemap.h"

#include <cstdint>
#include <vector>

namespace haarfield {

/// Incident radiance by direction: lat-long as cubemap.h lays it out. [W/(m^2 sr)]
struct LatLongImage {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;  ///< Row by row from the top, width * height.
};

/// A distant disc of even radiance: the sun, which is much smaller than a pixel of most images.
struct SunDisc {
    Vec3f direction{0, 1, 0};         ///< Towards its middle; unit length.
    float angular_radius = 0.00465f;  ///< Half its apparent size; above 0, up to 0.1. [rad]
    Rgb irradiance{0, 0, 0};          ///< On a surface that faces it: radiance * solid angle. [W/m^2]
};

/// Directions that are spread evenly over a disc: each stands for an equal share of its solid angle. The
/// first is near the middle; they wind outwards by the golden angle.
///
/// count  at least 1.
/// turn   all of them about the middle. [rad]
std::vector<Vec3f> disc_directions(const SunDisc& disc, int count, double turn = 0);

/// All of a scene's distant light: an image, and discs that are not in it.
struct Environment {
    LatLongImage image;
    std::vector<SunDisc> suns;

    Environment() = default;
    /// An image alone is an environment, too.
    Environment(LatLongImage of, std::vector<SunDisc> discs = {})  // NOLINT: an image is an environment
        : image(std::move(of)), suns(std::move(discs)) {}
};

/// As one image: the discs' energy is spread over the pixels that they cover. For backgrounds, and for light
/// that need not be sharp.
LatLongImage image_with_suns(const Environment& environment);

/// How uneven an image's light is: the root mean square of its luminance over its mean, over all directions.
/// 1 if it is even, or black.
double unevenness(const LatLongImage& image);

/// What was found in an environment image, and mended.
struct EnvironmentFindings {
    std::uint64_t negative_values = 0;    ///< Channels below zero (minus infinity too), set to zero.
    std::uint64_t non_finite_values = 0;  ///< NaN, set to zero; infinite, set to the largest finite value.
};

/// Sets negative and NaN channels to zero and infinite ones to the largest finite value of the image, or
/// to zero if there is none above it.
EnvironmentFindings clean_environment(LatLongImage& image);

/// Multiplies by 2^exposure and turns the environment about +y by `rotation` [rad], counter-clockwise
/// seen from above: what was in direction +z comes from +x after a quarter turn. Exact for turns by
/// whole pixels (to 1e-4 of one); otherwise neighbouring columns are mixed linearly, so that no energy
/// is lost.
LatLongImage turned_environment(const LatLongImage& image, double rotation, double exposure);

/// The same with its discs.
Environment turned_environment(const Environment& environment, double rotation, double exposure);

/// Radiance from a direction (of any length but zero), interpolated between pixels.
Rgb radiance_from(const LatLongImage& image, const Vec3d& direction);

/// Solid angle of each pixel of a row. Rows add up to 4 pi / width. [sr]
double lat_long_pixel_solid_angle(int row, int width, int height);

}  // namespace haarfield
