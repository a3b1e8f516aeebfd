#include "shading/scene/sky.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace haarfield {
namespace {

// Numbers and formulas are from Preetham, Shirley and Smits 1999, appendix A, unless stated otherwise. Units
// during the computation are photometric, kcd/m^2 and klx; the final scaling removes them.

/// Illuminance of the sun above the atmosphere (IES). [klx]
inline constexpr double solar_illuminance = 127.5;
/// CIE chromaticity of a black body at the sun's 5778 K.
inline constexpr double solar_x = 0.3265, solar_y = 0.3359;

/// Converts CIE x, y and luminance Y to linear sRGB (D65).
Vec3d rgb_of(double x, double y, double luminance_y) {
    const double big_x = x / y * luminance_y, big_z = (1 - x - y) / y * luminance_y;
    return {3.2404542 * big_x - 1.5371385 * luminance_y - 0.4985314 * big_z,
            -0.9692660 * big_x + 1.8760108 * luminance_y + 0.0415560 * big_z,
            0.0556434 * big_x - 0.2040259 * luminance_y + 1.0572252 * big_z};
}

/// Perez's distribution of one quantity over the sky, with its value at the zenith.
struct PerezDistribution {
    std::array<double, 5> c;  ///< A to E in the paper.
    double at_zenith;         ///< Value at the zenith over `relative` there.

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

/// Returns the illuminance of the sun on a plane that faces it. Includes the transmittance of Rayleigh
/// scattering, Angstrom's aerosols and ozone, each at one wavelength per channel. Omits mixed gases and water
/// vapour, which absorb mostly in the infrared.
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

/// A sky before scaling, with black ground.
struct RawSky {
    int width, height;
    std::vector<Vec3d> pixels;
    std::vector<double> sky_share;  ///< By row: fraction of its pixels above the horizon.
    SunDisc sun;                    ///< The whole disc.
    Vec3d sun_irradiance;

    Vec3d& pixel(const Vec3f& direction, int& row) {
        double x, y;
        lat_long_point(Vec3d(direction), x, y);
        const int column = std::min(int(x * width), width - 1);
        row = std::min(int(y * height), height - 1);
        return pixels[std::size_t(row) * std::size_t(width) + std::size_t(column)];
    }
    /// Returns the irradiance of the ground by the pixels: int cos dw over the fraction of a pixel above the
    /// horizon.
    Vec3d irradiance() const {
        Vec3d sum(0, 0, 0);
        for (int row = 0; 2 * row < height; ++row) {
            const double top = std::cos(pi * row / height),
                         bottom = std::cos(pi * std::min((row + 1.0) / height, 0.5));
            const double weight = pi / width * (top * top - bottom * bottom) / sky_share[std::size_t(row)];
            for (int column = 0; column < width; ++column)
                sum += pixels[std::size_t(row) * std::size_t(width) + std::size_t(column)] * weight;
        }
        return sum;
    }
    /// Returns the scale of all radiance for an irradiance of the ground.
    static double scale(const Vec3d& irradiance) {
        return pi / (0.2126 * irradiance.x + 0.7152 * irradiance.y + 0.0722 * irradiance.z);
    }
    LatLongImage scaled_image(const Vec3d& irradiance, const Rgb& ground_albedo) const {
        const Vec3d ground = irradiance * Vec3d(ground_albedo) / pi;
        LatLongImage image{width, height, std::vector<Rgb>(pixels.size())};
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            const Vec3d value =
                (pixels[i] + ground * (1 - sky_share[i / std::size_t(width)])) * scale(irradiance);
            image.pixels[i] = Rgb(float(value.x), float(value.y), float(value.z));
        }
        return image;
    }
};

/// Number of sample directions of the sun's disc.
constexpr int sun_samples = 8192;

RawSky raw_sky(const AnalyticSky& sky, int width) {
    assert(width >= 2 && width % 2 == 0);
    assert(sky.turbidity >= 2 && sky.turbidity <= 10);
    assert(sky.sun_elevation >= 0 && sky.sun_elevation <= 1.570797f);
    assert(sky.sun_angular_radius > 0 && sky.sun_angular_radius <= 0.1f);
    const int height = width / 2;
    const double elevation = double(sky.sun_elevation), azimuth = double(sky.sun_azimuth);
    const Vec3d sun(std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                    std::cos(elevation) * std::sin(azimuth));
    const Daylight model = daylight(double(sky.turbidity), pi / 2 - elevation);
    RawSky raw{width,
               height,
               std::vector<Vec3d>(std::size_t(width) * std::size_t(height), Vec3d(0, 0, 0)),
               std::vector<double>(std::size_t(height), 0.0),
               {Vec3f(sun), sky.sun_angular_radius, {}},
               sun_irradiance(double(sky.turbidity), elevation)};

    // Averages samples over every pixel. Four rows of samples, so that a pixel halved by the horizon is half
    // sky.
    constexpr int samples = 4;
    for (int row = 0; row < height; ++row)
        for (int i = 0; i < samples; ++i) {
            const double y = (row + (i + 0.5) / samples) / height;
            if (y >= 0.5) continue;
            raw.sky_share[std::size_t(row)] += 1.0 / samples;
            for (int column = 0; column < width; ++column) {
                const Vec3d direction = lat_long_direction((column + (i % 2 + 0.5) / 2) / width, y);
                const double gamma = std::acos(std::clamp(direction.dot(sun), -1.0, 1.0));
                raw.pixels[std::size_t(row) * std::size_t(width) + std::size_t(column)] +=
                    model.radiance(direction.y, gamma) / samples;
            }
        }
    return raw;
}

}  // namespace

LatLongImage sky_image(const AnalyticSky& sky, int width) {
    RawSky raw = raw_sky(sky, width);
    for (const Vec3f& direction : disc_directions(raw.sun, sun_samples)) {
        if (direction.y <= 0) continue;
        int row;
        Vec3d& pixel = raw.pixel(direction, row);
        pixel += raw.sun_irradiance / (sun_samples * lat_long_pixel_solid_angle(row, raw.width, raw.height));
    }
    return raw.scaled_image(raw.irradiance(), sky.ground);
}

Environment sky_environment(const AnalyticSky& sky, int width) {
    RawSky raw = raw_sky(sky, width);
    double above = 0, cosine = 0;
    for (const Vec3f& direction : disc_directions(raw.sun, sun_samples))
        if (direction.y > 0) {
            above += 1.0 / sun_samples;
            cosine += double(direction.y) / sun_samples;
        }
    const Vec3d irradiance = raw.irradiance() + raw.sun_irradiance * cosine;
    raw.sun.irradiance = Rgb(Vec3f(raw.sun_irradiance * (above * RawSky::scale(irradiance))));
    return {raw.scaled_image(irradiance, sky.ground), {raw.sun}};
}

}  // namespace haarfield
