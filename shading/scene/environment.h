#pragma once
/// Distant light: lat-long images of incident radiance and discs of suns; their cleaning and rotation.

#include "fields/wavelets/cubemap.h"

#include <cstdint>
#include <vector>

namespace haarfield {

/// Incident radiance by direction; lat-long layout as in cubemap.h. [W/(m^2 sr)]
struct LatLongImage {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;  ///< Rows from the top, width * height.
};

/// A distant disc of uniform radiance: a sun, which is much smaller than a pixel of most images.
struct SunDisc {
    Vec3f direction{0, 1, 0};         ///< Towards its centre; unit length.
    float angular_radius = 0.00465f;  ///< Half its apparent size; above 0, up to 0.1. [rad]
    Rgb irradiance{0, 0, 0};          ///< On a surface that faces it: radiance * solid angle. [W/m^2]
};

/// Returns directions spread evenly over a disc, each for an equal fraction of its solid angle. They form a
/// spiral outwards from the centre, by the golden angle.
///
/// count  at least 1.
/// turn   rotation of the spiral about the centre. [rad]
std::vector<Vec3f> disc_directions(const SunDisc& disc, int count, double turn = 0);

/// All distant light of a scene: an image, and discs that the image does not contain.
struct Environment {
    LatLongImage image;
    std::vector<SunDisc> suns;
    /// Pictures show it instead of the image and the suns, and it lights nothing. Empty: they show both.
    LatLongImage backdrop{};

    Environment() = default;
    /// Converts an image to an environment.
    Environment(LatLongImage of, std::vector<SunDisc> discs = {})  // NOLINT: an image is an environment
        : image(std::move(of)), suns(std::move(discs)) {}
};

/// Returns the environment as pictures show it: its backdrop, or one image, with the energy of the discs
/// spread over the pixels that they cover. An environment that is moved in is changed in place.
LatLongImage image_with_suns(Environment environment);

/// Returns a black environment whose backdrop is the given one.
Environment as_backdrop(Environment environment);

/// Returns the unevenness of an image's light: the root mean square of its luminance over its mean, over all
/// directions. 1 for uniform or black images.
double unevenness(const LatLongImage& image);

/// Counts of invalid values in an environment image.
struct EnvironmentFindings {
    std::uint64_t negative_values = 0;    ///< Channels below zero (including minus infinity), set to zero.
    std::uint64_t non_finite_values = 0;  ///< NaN, set to zero; infinity, set to the largest finite value.
};

/// Sets negative and NaN channels to zero. Sets infinite channels to the largest finite value of the image,
/// or to zero if the image has no positive value.
EnvironmentFindings clean_environment(LatLongImage& image);

/// Multiplies radiance by 2^exposure and rotates the environment about +y by `rotation` [rad],
/// counter-clockwise seen from above: a quarter turn moves +z to +x. Rotations by whole pixels (to 1e-4 of
/// one) are exact. Otherwise neighbouring columns are interpolated linearly, which preserves energy. Costs
/// one pass over the pixels, none if nothing changes; an image that is moved in is changed in place.
LatLongImage turned_environment(LatLongImage image, double rotation, double exposure);

/// Rotates and exposes an environment with its discs and its backdrop.
Environment turned_environment(Environment environment, double rotation, double exposure);

/// Returns the radiance from a direction (of any nonzero length), interpolated between pixels.
Rgb radiance_from(const LatLongImage& image, const Vec3d& direction);

/// Returns the solid angle of each pixel of a row. The rows' values add up to 4 pi / width. [sr]
double lat_long_pixel_solid_angle(int row, int width, int height);

}  // namespace haarfield
