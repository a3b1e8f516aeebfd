#include "shading/scene/sky.h"

#include <gtest/gtest.h>

#include <cmath>

namespace haarfield {
namespace {

AnalyticSky sky_at(double elevation_degrees, double turbidity = 3) {
    AnalyticSky sky;
    sky.turbidity = float(turbidity);
    sky.sun_elevation = float(elevation_degrees * pi / 180);
    return sky;
}

double pixel_luminance(const LatLongImage& image, const Vec3d& direction) {
    double x, y;
    lat_long_point(direction, x, y);
    const int column = std::min(int(x * image.width), image.width - 1);
    const int row = std::min(int(y * image.height), image.height - 1);
    return double(luminance(image.pixels[std::size_t(row * image.width + column)]));
}

/// Returns the irradiance of a horizontal surface that faces up, by the midpoint rule within pixels.
Vec3d irradiance(const LatLongImage& image, bool upper = true) {
    Vec3d sum(0, 0, 0);
    for (int row = 0; row < image.height; ++row)
        for (int part = 0; part < 8; ++part) {
            const double latitude = pi * (0.5 - (row + (part + 0.5) / 8) / image.height);
            if ((latitude > 0) != upper) continue;
            const double weight = std::abs(std::sin(latitude)) * std::cos(latitude) * pi / image.height / 8 *
                                  2 * pi / image.width;
            for (int column = 0; column < image.width; ++column)
                sum += Vec3d(image.pixels[std::size_t(row * image.width + column)]) * weight;
        }
    return sum;
}

TEST(Sky, GivesAWhiteHorizontalSurfaceALuminanceOfOne) {
    for (const double elevation : {0.0, 5.0, 40.0, 90.0})
        for (const double turbidity : {2.0, 3.0, 10.0})
            for (const int width : {32, 34, 256}) {
                AnalyticSky sky = sky_at(elevation, turbidity);
                sky.ground = Rgb(0.0f);  // the row that the horizon halves would include it
                const Vec3d sum = irradiance(sky_image(sky, width));
                const double outgoing = (0.2126 * sum.x + 0.7152 * sum.y + 0.0722 * sum.z) / pi;
                // For an odd height, the sky of the middle row is spread over the whole row.
                EXPECT_NEAR(outgoing, 1, width == 34 ? 0.05 : 0.002)
                    << "elevation " << elevation << ", turbidity " << turbidity << ", width " << width;
            }
}

TEST(Sky, IsFiniteAndNowhereNegative) {
    for (double elevation = 0; elevation <= 90; elevation += 5)
        for (const double turbidity : {2.0, 5.0, 10.0})
            for (const Rgb& pixel : sky_image(sky_at(elevation, turbidity), 64).pixels)
                for (int channel = 0; channel < 3; ++channel) {
                    ASSERT_TRUE(std::isfinite(pixel[channel])) << elevation << ", " << turbidity;
                    ASSERT_GE(pixel[channel], 0.0f) << elevation << ", " << turbidity;
                }
}

TEST(Sky, HasItsSunInTheGivenDirection) {
    for (const double elevation : {5.0, 40.0, 80.0})
        for (const double azimuth : {0.0, 1.0, 2.5, -2.0}) {
            AnalyticSky sky = sky_at(elevation);
            sky.sun_azimuth = float(azimuth);
            const LatLongImage image = sky_image(sky, 256);
            std::size_t brightest = 0;
            for (std::size_t i = 0; i < image.pixels.size(); ++i)
                if (luminance(image.pixels[i]) > luminance(image.pixels[brightest])) brightest = i;
            const double e = elevation * pi / 180;
            const Vec3d sun(std::cos(e) * std::cos(azimuth), std::sin(e), std::cos(e) * std::sin(azimuth));
            const Vec3d found = lat_long_direction((double(brightest % 256) + 0.5) / 256,
                                                   (double(brightest / 256) + 0.5) / 128);
            EXPECT_GT(found.dot(sun), std::cos(2 * pi / 256)) << elevation << ", " << azimuth;
        }
}

TEST(Sky, HasTheSameSunlightForAnySizeOfTheSunAndAnyResolution) {
    // The irradiance of the image, including the sun, relative to the luminance of a pixel of the sky.
    const auto relative_irradiance = [](float radius, int width) {
        AnalyticSky sky = sky_at(40);
        sky.sun_angular_radius = radius;
        const LatLongImage image = sky_image(sky, width);
        return irradiance(image).y / pixel_luminance(image, Vec3d(-0.3, 0.8, -0.3));
    };
    const double expected = relative_irradiance(0.00465f, 512);
    EXPECT_NEAR(relative_irradiance(0.05f, 512), expected, 0.005 * expected);
    EXPECT_NEAR(relative_irradiance(0.00465f, 128), expected, 0.03 * expected);
    // The sun is included: the irradiance of the sky alone is about 2 pi.
    EXPECT_GT(expected, 3.5 * pi);
}

TEST(Sky, IsPreethamsModelOnTheMeridianOfTheSun) {
    // Ratios of luminance, computed by hand from the paper's formulas for turbidity 2 and a sun at 60 degrees
    // from the zenith: Perez's A to E are -1.1056, -0.2833, 5.2797, -2.3359, 0.2363.
    const auto perez = [](double zenith, double gamma) {
        return (1 - 1.1056 * std::exp(-0.2833 / std::cos(zenith))) *
               (1 + 5.2797 * std::exp(-2.3359 * gamma) + 0.2363 * std::cos(gamma) * std::cos(gamma));
    };
    AnalyticSky sky = sky_at(30, 2);
    sky.sun_azimuth = 0;
    const LatLongImage image = sky_image(sky, 720);
    const double at_zenith = pixel_luminance(image, Vec3d(0.001, 1, 0.001));
    for (const double degrees : {-80.25, -45.25, -20.25, 20.25, 45.25, 75.25}) {
        const double zenith = degrees * pi / 180;
        const double expected = perez(std::abs(zenith), std::abs(zenith - pi / 3)) / perez(0, pi / 3);
        const double found = pixel_luminance(image, Vec3d(std::sin(zenith), std::cos(zenith), 0)) / at_zenith;
        EXPECT_NEAR(found, expected, 0.02 * expected) << degrees << " degrees from the zenith";
    }
}

TEST(Sky, IsBlueOverheadAndReddensTowardsALowSun) {
    const auto red_to_blue = [](const LatLongImage& image, const Vec3d& direction) {
        double x, y;
        lat_long_point(direction, x, y);
        const Rgb& pixel =
            image.pixels[std::size_t(int(y * image.height) * image.width + int(x * image.width))];
        return double(pixel.x / pixel.z);
    };
    AnalyticSky low = sky_at(5), high = sky_at(60);
    low.sun_azimuth = high.sun_azimuth = 0;
    const LatLongImage evening = sky_image(low, 256), noon = sky_image(high, 256);
    EXPECT_LT(red_to_blue(noon, Vec3d(-0.5, 1, 0)), 0.7);
    EXPECT_GT(red_to_blue(evening, Vec3d(1, 0.06, 0.15)), 1.0);
    const Vec3d sun_low(std::cos(5 * pi / 180), std::sin(5 * pi / 180), 0), sun_high(0.5, std::sqrt(0.75), 0);
    EXPECT_GT(red_to_blue(evening, sun_low), 1.5 * red_to_blue(noon, sun_high));
}

TEST(Sky, FillsTheLowerHalfWithTheGroundsReflection) {
    AnalyticSky sky = sky_at(40);
    sky.ground = Rgb(0.5f, 0.25f, 0.0f);
    const LatLongImage image = sky_image(sky, 128);
    const Vec3d sum = irradiance(image);
    for (std::size_t i = image.pixels.size() / 2; i < image.pixels.size(); ++i) {
        EXPECT_NEAR(image.pixels[i].x, 0.5 * sum.x / pi, 2e-3);
        EXPECT_NEAR(image.pixels[i].y, 0.25 * sum.y / pi, 2e-3);
        EXPECT_EQ(image.pixels[i].z, 0.0f);
    }
}

}  // namespace
}  // namespace haarfield
