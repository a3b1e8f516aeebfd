#include "bridge/povray/light_dome.h"

#include <gtest/gtest.h>

#include <random>

namespace haarfield {
namespace {

/// Returns a sky that is brighter at the top, walls of several colours, and a sun of 2 x 2 pixels with half
/// of the energy.
LatLongImage room(int height, unsigned seed) {
    std::mt19937 random(seed);
    LatLongImage image{2 * height, height, {}};
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < 2 * height; ++column) {
            const float up = 1 - static_cast<float>(row) / static_cast<float>(height);
            const float side = 0.5f + 0.5f * std::sin(0.1f * static_cast<float>(column));
            image.pixels.emplace_back(0.2f + up, 0.3f * side + up * up,
                                      0.1f + static_cast<float>(random() % 100) / 100);
        }
    for (int row : {height / 4, height / 4 + 1})
        for (int column : {height / 3, height / 3 + 1}) {
            const double solid_angle = lat_long_pixel_solid_angle(row, 2 * height, height);
            image.pixels[static_cast<std::size_t>(row * 2 * height + column)] =
                Rgb(2, 1.5f, 1) * static_cast<float>(1 / solid_angle);
        }
    return image;
}

TEST(LightDome, KeepsTheEnergyOfEachChannel) {
    for (int lights : {8, 100, 1000, 100000}) {
        const LatLongImage image = room(32, 1);
        Vec3d expected(0, 0, 0), found(0, 0, 0);
        for (int row = 0; row < 32; ++row)
            for (int column = 0; column < 64; ++column) {
                const Rgb& p = image.pixels[static_cast<std::size_t>(64 * row + column)];
                expected += Vec3d(p.x, p.y, p.z) * lat_long_pixel_solid_angle(row, 64, 32);
            }
        const std::vector<DirectionalLight> dome = light_dome(image, {.lights = lights});
        EXPECT_LE(dome.size(), static_cast<std::size_t>(lights));
        for (const DirectionalLight& light : dome) {
            found += Vec3d(light.irradiance.x, light.irradiance.y, light.irradiance.z);
            EXPECT_NEAR(light.direction.length(), 1, 1e-5);
        }
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / expected[c], 1, 1e-5) << lights << " lights";
    }
}

TEST(LightDome, LightsPlanesLikeTheEnvironment) {
    const LatLongImage image = room(64, 2);
    std::mt19937 random(3);
    const auto check = [&](int lights, double tolerance) {
        const std::vector<DirectionalLight> dome = light_dome(image, {.lights = lights});
        for (int k = 0; k < 40; ++k) {
            Vec3d normal;
            do
                for (int c = 0; c < 3; ++c) normal[c] = static_cast<double>(random()) / 2147483648.0 - 1;
            while (normal.length() > 1 || normal.length() < 0.1);
            normal.normalize();
            Vec3d expected(0, 0, 0), found(0, 0, 0);
            for (int row = 0; row < 64; ++row)
                for (int column = 0; column < 128; ++column) {
                    const Rgb& p = image.pixels[static_cast<std::size_t>(128 * row + column)];
                    const double cosine =
                        normal.dot(lat_long_direction((column + 0.5) / 128, (row + 0.5) / 64));
                    if (cosine > 0)
                        expected +=
                            Vec3d(p.x, p.y, p.z) * (cosine * lat_long_pixel_solid_angle(row, 128, 64));
                }
            for (const DirectionalLight& light : dome) {
                const double cosine = normal.dot(Vec3d(light.direction));
                if (cosine > 0)
                    found += Vec3d(light.irradiance.x, light.irradiance.y, light.irradiance.z) * cosine;
            }
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c] / expected[c], 1, tolerance) << lights << " lights, normal " << k;
        }
    };
    check(256, 0.01);
    check(1024, 0.003);
}

TEST(LightDome, LeavesASunOfOnePixelInItsPlace) {
    LatLongImage image{128, 64, {}};
    image.pixels.assign(128 * 64, Rgb(0.01f, 0.01f, 0.01f));
    image.pixels[20 * 128 + 77] = Rgb(5000, 5000, 5000);
    const std::vector<DirectionalLight> dome = light_dome(image, {.lights = 64});
    const DirectionalLight* brightest = &dome.front();
    for (const DirectionalLight& light : dome)
        if (luminance(light.irradiance) > luminance(brightest->irradiance)) brightest = &light;
    const Vec3d sun = lat_long_direction(77.5 / 128, 20.5 / 64);
    EXPECT_NEAR((Vec3d(brightest->direction) - sun).length(), 0, 1e-4);
    EXPECT_NEAR(brightest->irradiance.x, 5000 * lat_long_pixel_solid_angle(20, 128, 64), 1e-3);
}

/// Returns the cosine of the widest angle between a direction and its nearest light.
double widest_hole(const std::vector<DirectionalLight>& dome) {
    double widest = 1;
    for (int row = 0; row < 64; row += 3)
        for (int column = 0; column < 128; column += 3) {
            const Vec3d direction = lat_long_direction((column + 0.5) / 128, (row + 0.5) / 64);
            double nearest = -1;
            for (const DirectionalLight& light : dome)
                nearest = std::max(nearest, direction.dot(Vec3d(light.direction)));
            widest = std::min(widest, nearest);
        }
    return widest;
}

TEST(LightDome, LeavesNoWideHoleInADimSky) {
    // A bright window, with more pixels than there are lights.
    LatLongImage image{128, 64, {}};
    image.pixels.assign(128 * 64, Rgb(0.01f, 0.01f, 0.01f));
    for (int row = 16; row < 36; ++row)
        for (int column = 20; column < 80; ++column)
            image.pixels[static_cast<std::size_t>(row * 128 + column)] = Rgb(500, 500, 500);
    EXPECT_GT(widest_hole(light_dome(image, {.lights = 512})), std::cos(20 * pi / 180));
    EXPECT_LT(widest_hole(light_dome(image, {.lights = 512, .uniform_share = 0})), std::cos(40 * pi / 180));
}

TEST(LightDome, IsEmptyInTheDarkAndEqualForEqualInput) {
    LatLongImage black{16, 8, {}};
    black.pixels.assign(128, Rgb(0, 0, 0));
    EXPECT_TRUE(light_dome(black, {.lights = 64}).empty());
    const std::vector<DirectionalLight> a = light_dome(room(16, 4)), b = light_dome(room(16, 4));
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a[i].direction, b[i].direction);
        EXPECT_EQ(a[i].irradiance, b[i].irradiance);
    }
}

}  // namespace
}  // namespace haarfield
