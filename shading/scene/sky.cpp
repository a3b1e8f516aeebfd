#include "shading/scene/sky.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace haarfield {
namespace {

// Numbers and formulas of this file, unless said otherwise: Preetham, Shirley and Smits 1999, appendix A.
// Photometric units while we compute: kcd/m^2 and klx; the scale is lost at the end.

/// Illuminance by the sun above the atmosphere (IES). [klx]
inline constexpr double solar_illuminance = 127.5;
/// CIE chromaticity of a black body at the sun's 5778 K.
inline constexpr double solar_x = 0.3265, solar_y = 0.3359;

/// Linear sRGB (D65) of CIE x, y and luminance Y.
Vec3d rgb_of(double x, double y, double luminance_y) {
    const double big_x = x / y * luminance_y, big_z = (1 - x - y) / y * luminance_y;
    return {3.2404542 * big_x - 1.5371385 * luminance_y - 0.4985314 * big_z,
            -0.9692660 * big_x + 1.8760108 * luminance_y + 0.0415560 * big_z,
            0.0556434 * big_x - 0.2040259 * luminance_y + 1.0572252 * big_z};
}

/// Perez's distribution of one quantity over the sky, and its value at the zenith.
struct PerezDistribution {
    std::array<double, 5> c;  ///< A to E in the paper.
    double at_zenith;         ///< The value there divided by that of `relative`.

    /// `zenith` is the cosine of the angle from the zenith, above 0; `gamma` the angle from the sun. [rad]
    double relative(double zenith, double gamma) const {
        const double cosine = std::cos(gamma);
        return (1 + c[0] * std::exp(c[1] / zenith)) *
               (1 + c[2] * std::exp(c[3] * gamma) + c[4] * cosine * cosine);
    }
    double value(double zenith, double gamma) const { return at_zenith * relative(zenith, gamma); }
};

struct Daylight {
    PerezDistribution luminance, x, y;

    Vec3d radiance(double zenith, double gamma) const {
        const Vec3d rgb = rgb_of(x.value(zenith, gamma), y.value(zenith, gamma),
                                 std::max(luminance.value(zenith, gamma), 0.0));
        return {std::max(rgb.x, 0.0), std::max(rgb.y, 0.0), std::max(rgb.z, 0.0)};
    }
};

/// sun: angle from the zenith. [rad]
Daylight daylight(double turbidity, double sun) {
    const double t = turbidity;
    const auto cubic = [&](double c3, double c2, double c1, double c0) {
        return ((c3 * sun + c2) * sun + c1) * sun + c0;
    };
    const double chi = (4.0 / 9.0 - t / 120) * (pi - 2 * sun);
    const double zenith_luminance = (4.0453 * t - 4.9710) * std::tan(chi) - 0.2155 * t + 2.4192;
    const double zenith_x = t * t * cubic(0.00166, -0.00375, 0.00209, 0) +
                            t * cubic(-0.02903, 0.06377, -0.03202, 0.00394) +
                            cubic(0.11693, -0.21196, 0.06052, 0.25886);
    const double zenith_y = t * t * cubic(0.00275, -0.00610, 0.00317, 0) +
                            t * cubic(-0.04214, 0.08970, -0.04153, 0.00516) +
                            cubic(0.15346, -0.26756, 0.06670, 0.26688);
    Daylight sky{{{0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771,
                   -0.0670 * t + 0.3703},
                  0},
                 {{-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989,
                   -0.0033 * t + 0.0452},
                  0},
                 {{-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537,
                   -0.0109 * t + 0.0529},
                  0}};
    sky.luminance.at_zenith = zenith_luminance / sky.luminance.relative(1, sun);
    sky.x.at_zenith = zenith_x / sky.x.relative(1, sun);
    sky.y.at_zenith = zenith_y / sky.y.relative(1, sun);
    return sky;
}

/// Illuminance by the sun on a plane that faces it. Transmittance by Rayleigh scattering, Angstrom's aerosols
/// and ozone, each at one wavelength for a channel; mixed gases and water vapour, which absorb mostly in the
/// infrared, are left out.
Vec3d sun_irradiance(double turbidity, double elevation) {
    constexpr std::array<double, 3> wavelength{0.610, 0.550, 0.465};        // [um]
    constexpr std::array<double, 3> ozone_absorption{0.120, 0.085, 0.009};  // [1/cm]
    constexpr double ozone = 0.35;                                          // [cm]
    // Degrees from the zenith; the formula for the relative air mass holds down to the horizon.
    const double zenith = 90 - elevation * 180 / pi;
    const double air_mass = 1 / (std::sin(elevation) + 0.15 * std::pow(93.885 - zenith, -1.253));
    const double aerosols = 0.04608 * turbidity - 0.04586;
    const Vec3d above = rgb_of(solar_x, solar_y, solar_illuminance);
    Vec3d below;
    for (int i = 0; i < 3; ++i) {
        const double um = wavelength[std::size_t(i)];
        const double depth = 0.008735 * std::pow(um, -4.08) + aerosols * std::pow(um, -1.3) +
                             ozone_absorption[std::size_t(i)] * ozone;
        below[i] = above[i] * std::exp(-depth * air_mass);
    }
    return below;
}

/// Calls `visit` with directions that are spread evenly over the disc of the sun, each for an equal share of
/// its solid angle: `share` of the whole.
template <class Visit>
void for_each_sun_sample(const Vec3d& sun, double angular_radius, const Visit& visit) {
    constexpr int rings = 64, spokes = 128;
    const Vec3d any = std::abs(sun.y) < 0.9 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0);
    const Vec3d right = any.cross(sun).normalized(), up = sun.cross(right);
    for (int ring = 0; ring < rings; ++ring) {
        // Rings of equal solid angle: 1 - cosine grows evenly. In half angles, because it is small.
        const double half_sine = std::sin(angular_radius / 2) * std::sqrt((ring + 0.5) / rings);
        const double cosine = 1 - 2 * half_sine * half_sine;
        const double sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
        for (int spoke = 0; spoke < spokes; ++spoke) {
            const double angle = 2 * pi * (spoke + 0.5 * (ring % 2)) / spokes;
            visit(sun * cosine + (right * std::cos(angle) + up * std::sin(angle)) * sine,
                  1.0 / (rings * spokes));
        }
    }
}

}  // namespace

LatLongImage sky_image(const AnalyticSky& sky, int width) {
    assert(width >= 2 && width % 2 == 0);
    assert(sky.turbidity >= 2 && sky.turbidity <= 10);
    assert(sky.sun_elevation >= 0 && sky.sun_elevation <= 1.570797f);
    assert(sky.sun_angular_radius > 0 && sky.sun_angular_radius <= 0.1f);
    const int height = width / 2;
    const double elevation = double(sky.sun_elevation), azimuth = double(sky.sun_azimuth);
    const Vec3d sun(std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                    std::cos(elevation) * std::sin(azimuth));
    const Daylight model = daylight(double(sky.turbidity), pi / 2 - elevation);

    // The sky, as the mean over samples of every pixel. Four rows of them, so that a pixel that the horizon
    // halves is sky by half. Its ground stays black until the irradiance is known.
    constexpr int samples = 4;
    std::vector<Vec3d> pixels(std::size_t(width) * std::size_t(height), Vec3d(0, 0, 0));
    std::vector<double> sky_share(std::size_t(height), 0.0);
    for (int row = 0; row < height; ++row)
        for (int i = 0; i < samples; ++i) {
            const double y = (row + (i + 0.5) / samples) / height;
            if (y >= 0.5) continue;
            sky_share[std::size_t(row)] += 1.0 / samples;
            for (int column = 0; column < width; ++column) {
                const Vec3d direction = lat_long_direction((column + (i % 2 + 0.5) / 2) / width, y);
                const double gamma = std::acos(std::clamp(direction.dot(sun), -1.0, 1.0));
                pixels[std::size_t(row) * std::size_t(width) + std::size_t(column)] +=
                    model.radiance(direction.y, gamma) / samples;
            }
        }

    const Vec3d irradiance_by_sun = sun_irradiance(double(sky.turbidity), elevation);
    for_each_sun_sample(sun, double(sky.sun_angular_radius), [&](const Vec3d& direction, double share) {
        if (direction.y <= 0) return;  // set already
        double x, y;
        lat_long_point(direction, x, y);
        const int column = std::min(int(x * width), width - 1), row = std::min(int(y * height), height - 1);
        pixels[std::size_t(row) * std::size_t(width) + std::size_t(column)] +=
            irradiance_by_sun * (share / lat_long_pixel_solid_angle(row, width, height));
    });

    // Irradiance of the ground, by the pixels as they are: int cos dw over a pixel's part above the horizon.
    Vec3d irradiance(0, 0, 0);
    for (int row = 0; 2 * row < height; ++row) {
        const double top = std::cos(pi * row / height),
                     bottom = std::cos(pi * std::min((row + 1.0) / height, 0.5));
        const double weight = pi / width * (top * top - bottom * bottom) / sky_share[std::size_t(row)];
        for (int column = 0; column < width; ++column)
            irradiance += pixels[std::size_t(row) * std::size_t(width) + std::size_t(column)] * weight;
    }
    const double scale = pi / (0.2126 * irradiance.x + 0.7152 * irradiance.y + 0.0722 * irradiance.z);
    const Vec3d ground = irradiance * Vec3d(sky.ground) / pi;

    LatLongImage image{width, height, std::vector<Rgb>(pixels.size())};
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const Vec3d value = (pixels[i] + ground * (1 - sky_share[i / std::size_t(width)])) * scale;
        image.pixels[i] = Rgb(float(value.x), float(value.y), float(value.z));
    }
    return image;
}

}  // namespace haarfield
