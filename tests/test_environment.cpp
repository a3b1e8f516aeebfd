#include "shading/scene/environment.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

LatLongImage noise_image(int width, int height, std::uint32_t seed) {
    LatLongImage image{width, height, {}};
    const auto values = reference::noise_texels(seed, 3 * std::size_t(width) * std::size_t(height));
    for (std::size_t i = 0; i < values.size(); i += 3)
        image.pixels.push_back(Rgb(values[i], values[i + 1], values[i + 2]));
    return image;
}

Vec3d energy(const LatLongImage& image) {
    Vec3d sum(0, 0, 0);
    for (int row = 0; row < image.height; ++row)
        for (int column = 0; column < image.width; ++column)
            sum += Vec3d(image.pixels[std::size_t(row * image.width + column)]) *
                   lat_long_pixel_solid_angle(row, image.width, image.height);
    return sum;
}

TEST(CleanEnvironment, RepairsAndCountsInvalidChannels) {
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    LatLongImage image{2, 2, {Rgb(1, -2, 3), Rgb(inf, nan, -inf), Rgb(0, 7, -0.0f), Rgb(nan, inf, 0.5f)}};
    const EnvironmentFindings findings = clean_environment(image);
    EXPECT_EQ(findings.negative_values, 2u);  // -2 and -inf
    EXPECT_EQ(findings.non_finite_values, 4u);
    const std::vector<Rgb> expected{Rgb(1, 0, 3), Rgb(7, 0, 0), Rgb(0, 7, 0), Rgb(0, 7, 0.5f)};
    EXPECT_EQ(image.pixels, expected);
}

TEST(CleanEnvironment, LeavesAValidImageUnchanged) {
    LatLongImage image = noise_image(8, 4, 1);
    const std::vector<Rgb> before = image.pixels;
    const EnvironmentFindings findings = clean_environment(image);
    EXPECT_EQ(findings.negative_values + findings.non_finite_values, 0u);
    EXPECT_EQ(image.pixels, before);
}

TEST(CleanEnvironment, MakesAnImageWithoutFiniteValuesBlack) {
    const float inf = std::numeric_limits<float>::infinity();
    LatLongImage image{1, 1, {Rgb(inf, inf, -1)}};
    clean_environment(image);
    EXPECT_EQ(image.pixels[0], Rgb(0, 0, 0));
}

TEST(TurnedEnvironment, RotatesPlusZToPlusXInAQuarterTurn) {
    // A bright pixel next to +z. A quarter turn must move it next to +x.
    LatLongImage image{64, 32, std::vector<Rgb>(64 * 32, Rgb(0.0f))};
    const std::size_t row = 10, column = 34;
    image.pixels[row * 64 + column] = Rgb(5, 6, 7);
    const Vec3d from = lat_long_direction((double(column) + 0.5) / 64, (double(row) + 0.5) / 32);
    for (const double rotation : {pi / 2, double(float(pi / 2)), pi / 2 + 2 * pi, -1.5 * pi}) {
        const LatLongImage turned = turned_environment(image, rotation, 0);
        const Vec3d to(from.z, from.y, -from.x);
        double x, y;
        lat_long_point(to, x, y);
        for (std::size_t i = 0; i < turned.pixels.size(); ++i)
            EXPECT_EQ(turned.pixels[i], i == row * 64 + std::size_t(x * 64) ? Rgb(5, 6, 7) : Rgb(0, 0, 0))
                << "pixel " << i << ", rotation " << rotation;
    }
}

TEST(TurnedEnvironment, KeepsEnergyAndScalesItByExposure) {
    const LatLongImage image = noise_image(64, 32, 3);
    const Vec3d before = energy(image);
    for (const double rotation : {0.0, 0.1, 1.0, -2.0, 100.0})
        for (const double exposure : {0.0, 1.0, -2.5}) {
            const Vec3d after = energy(turned_environment(image, rotation, exposure));
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(after[channel], before[channel] * std::exp2(exposure), 2e-6 * after[channel])
                    << rotation << ", " << exposure;
        }
}

TEST(TurnedEnvironment, MixesNeighboursLinearlyBetweenPixels) {
    const LatLongImage image = noise_image(16, 8, 4);
    const LatLongImage turned = turned_environment(image, 2 * pi / 16 * 3.25, 0);
    for (std::size_t row = 0; row < 8; ++row)
        for (std::size_t column = 0; column < 16; ++column) {
            const Rgb expected = image.pixels[row * 16 + (column + 3) % 16] * 0.75f +
                                 image.pixels[row * 16 + (column + 4) % 16] * 0.25f;
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(turned.pixels[row * 16 + column][channel], expected[channel], 1e-5f);
        }
}

TEST(Backdrop, IsShownAndLightsNothing) {
    const LatLongImage image = noise_image(16, 8, 3);
    const Environment backdrop = as_backdrop(Environment(image));
    for (const Rgb& pixel : backdrop.image.pixels) EXPECT_EQ(pixel, Rgb(0.0f));
    EXPECT_TRUE(backdrop.suns.empty());
    EXPECT_EQ(image_with_suns(backdrop).pixels, image.pixels);
}

TEST(Backdrop, RotatesAndIsExposedLikeItsEnvironment) {
    const Environment environment(noise_image(16, 8, 4), {{Vec3f(0, 1, 0), 0.01f, Rgb(1.0f)}});
    EXPECT_EQ(image_with_suns(turned_environment(as_backdrop(environment), pi / 2, 1)).pixels,
              turned_environment(image_with_suns(environment), pi / 2, 1).pixels);
}

TEST(LatLongPixelSolidAngle, IsTheAreaBetweenParallelsAndAddsUpToTheSphere) {
    for (const auto& [width, height] : {std::pair(2, 1), {64, 32}, {100, 33}, {1024, 512}}) {
        double sum = 0;
        for (int row = 0; row < height; ++row) {
            // Midpoint rule over the cosine of the latitude.
            double cosines = 0;
            for (int i = 0; i < 100; ++i) cosines += std::cos(pi * ((row + (i + 0.5) / 100) / height - 0.5));
            const double expected = cosines / 100 * pi / height * 2 * pi / width;
            EXPECT_NEAR(lat_long_pixel_solid_angle(row, width, height), expected, 1e-4 * expected);
            sum += width * lat_long_pixel_solid_angle(row, width, height);
        }
        EXPECT_NEAR(sum, 4 * pi, 1e-11) << width << " x " << height;
    }
}

}  // namespace
}  // namespace haarfield
