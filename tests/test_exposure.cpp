#include "shading/scene/exposure.h"

#include <gtest/gtest.h>

#include <random>

#include "shading/scene/sky.h"

namespace haarfield {
namespace {

/// Returns an image with the radiance as a function of direction.
template <class Radiance>
LatLongImage image_of(int width, const Radiance& radiance) {
    LatLongImage image{width, width / 2, {}};
    for (int row = 0; row < image.height; ++row)
        for (int column = 0; column < width; ++column)
            image.pixels.push_back(
                radiance(lat_long_direction((column + 0.5) / width, (row + 0.5) / image.height)));
    return image;
}

/// Returns the largest radiance of a white sphere by brute force: all pixels, many normals.
double brightest_white(const LatLongImage& image) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    double brightest = 0;
    for (int i = 0; i < 3000; ++i) {
        const Vec3d facing = Vec3d(normal(random), normal(random), normal(random)).normalized();
        double irradiance = 0;
        for (int row = 0; row < image.height; ++row)
            for (int column = 0; column < image.width; ++column)
                irradiance += double(luminance(image.pixels[std::size_t(row * image.width + column)])) *
                              lat_long_pixel_solid_angle(row, image.width, image.height) *
                              std::max(0.0, facing.dot(lat_long_direction((column + 0.5) / image.width,
                                                                          (row + 0.5) / image.height)));
        brightest = std::max(brightest, 0.8 * irradiance / pi);
    }
    return brightest;
}

TEST(AutomaticExposure, MakesTheBrightestPointOfAWhiteSphereOne) {
    const auto lamp = [](const Vec3d& towards, double size, float bright) {
        return [=](const Vec3d& d) {
            return Rgb(d.dot(towards.normalized()) > 1 - size ? bright : 0.1f) * Rgb(1, 0.7f, 0.4f);
        };
    };
    for (const LatLongImage& image :
         {image_of(96, lamp({1, 0.1, -1}, 0.01, 300)), image_of(100, lamp({0, 1, 0.2}, 0.5, 0.02f)),
          image_of(30, lamp({0, -1, 0}, 0.3, 7)), image_of(80, [](const Vec3d& d) {
              return Rgb(float(1 + d.y), float(2 + d.x * d.z), float(std::abs(d.z)));
          })})
        EXPECT_NEAR(std::exp2(automatic_exposure(image)) * brightest_white(image), 1, 0.015);
}

TEST(AutomaticExposure, LeavesRoomForLocalLights) {
    const LatLongImage even = image_of(64, [](const Vec3d&) { return Rgb(5, 5, 5); });
    const ExposedLight half{Vec3d(0, 1, 0), 0.5 * pi / 0.8};
    EXPECT_NEAR(automatic_exposure(even, std::span(&half, 1)), automatic_exposure(even) - 1, 0.01);
    const ExposedLight bright{Vec3d(0, 1, 0), 100 * pi};
    EXPECT_NEAR(automatic_exposure(even, std::span(&bright, 1)), automatic_exposure(even) - 4, 0.01)
        << "at least a sixteenth";
    const ExposedLight dim{Vec3d(0, 1, 0), 1e-4};
    EXPECT_NEAR(automatic_exposure(even, std::span(&dim, 1)), automatic_exposure(even), 1e-3);
}

TEST(AutomaticExposure, IsExactForEvenLight) {
    // Irradiance is pi times the radiance for all normals.
    EXPECT_NEAR(automatic_exposure(image_of(64, [](const Vec3d&) { return Rgb(5, 5, 5); })),
                -std::log2(0.8 * 5), 0.005);
}

TEST(AutomaticExposure, CountsDiscsAsTheirPixelsWould) {
    const AnalyticSky sky;
    const float alone = automatic_exposure(sky_environment(sky, 256).image);
    const float found = automatic_exposure(sky_environment(sky, 256));
    EXPECT_NEAR(found, automatic_exposure(image_with_suns(sky_environment(sky, 256))), 0.02);
    EXPECT_LT(found, alone - 0.5f);
}

TEST(AutomaticExposure, FollowsTheBrightnessAndNotTheRotation) {
    const Environment light = sky_environment(AnalyticSky(), 256);
    const float found = automatic_exposure(light);
    EXPECT_NEAR(automatic_exposure(turned_environment(light, 0, 3)), found - 3, 1e-4);
    for (const double turn : {0.3, 2.0, 4.0})
        EXPECT_NEAR(automatic_exposure(turned_environment(light, turn, 0)), found, 0.02) << turn;
}

TEST(AutomaticExposure, IsZeroWithoutLightAndStaysInItsRange) {
    EXPECT_EQ(automatic_exposure(image_of(16, [](const Vec3d&) { return Rgb(0, 0, 0); })), 0);
    EXPECT_EQ(automatic_exposure(Environment()), 0);
    EXPECT_EQ(automatic_exposure(image_of(16, [](const Vec3d&) { return Rgb(1e30f, 0, 0); })), -60);
    EXPECT_EQ(automatic_exposure(image_of(16, [](const Vec3d&) { return Rgb(0, 1e-30f, 0); })), 60);
}

}  // namespace
}  // namespace haarfield
