#include "shading/scene/turned_light.h"

#include <gtest/gtest.h>

#include "shading/scene/lighting.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/relative_error.h"

namespace haarfield {
namespace {

Rgb sum_of(const std::vector<Rgb>& texels) {
    Vec3d sum(0.0);
    for (const Rgb& texel : texels) sum += Vec3d(texel);
    return Rgb(Vec3f(sum));
}

TEST(TurnedLight, OfAConstantEnvironmentIsConstant) {
    const LatLongImage grey = environment([](const Vec3d&) { return 0.7; }, 64);
    for (const int size : {16, 256}) {
        const std::vector<Rgb> wanted = lighting_texels(grey, size);
        const std::vector<Rgb> found =
            turned_lighting_texels(turnable_light(grey, size), rotation_about({1, 2, 3}, 1));
        ASSERT_EQ(found.size(), wanted.size());
        for (std::size_t i = 0; i < wanted.size(); ++i)
            ASSERT_NEAR(found[i].x, wanted[i].x, 1e-3f * wanted[i].x);
    }
}

TEST(TurnedLight, IsTheLightOfTheTurnedEnvironment) {
    const auto lobe = [](const Vec3d& d, const Vec3d& centre) { return std::exp(6 * (d.dot(centre) - 1)); };
    const Vec3d from = Vec3d(0.2, 0.5, 0.8).normalized();
    const LatLongImage image = environment([&](const Vec3d& d) { return lobe(d, from); }, 256);
    const TurnableLight light = turnable_light(image, 32);
    for (const Rotation& rotation : {Rotation(), rotation_about({0, 1, 0}, 0.7), rotation_about({1, 0, 0}, 2),
                                     rotation_about({1, -2, 0.5}, 4)}) {
        const Vec3d to = rotation(from);
        const LatLongImage turned = environment([&](const Vec3d& d) { return lobe(d, to); }, 256);
        EXPECT_LT(relative_rmse(turned_lighting_texels(light, rotation), lighting_texels(turned, 32)), 0.015);
    }
}

TEST(TurnedLight, TurnsTheWayThatEnvironmentsDo) {
    const LatLongImage image = environment([](const Vec3d& d) { return 1 + d.z + 0.5 * d.x; }, 128);
    EXPECT_LT(relative_rmse(turned_lighting_texels(turnable_light(image, 16), rotation_about({0, 1, 0}, 0.9)),
                            lighting_texels(turned_environment(image, 0.9, 0), 16)),
              0.01);
}

TEST(TurnedLight, KeepsEnergyAndPlaceOfASmallSun) {
    constexpr int size = 64;
    LatLongImage image = environment([](const Vec3d&) { return 0.01; }, 512);
    const std::size_t sun = 70 * 512 + 200;
    image.pixels[sun] = Rgb(1000, 500, 100);
    const Vec3d from = lat_long_direction(200.5 / 512, 70.5 / 256);
    const TurnableLight light = turnable_light(image, size);
    const Rgb wanted = sum_of(lighting_texels(image, size));
    const std::vector<Vec3f> directions = texel_directions(size);
    for (int i = 0; i < 20; ++i) {
        const Rotation rotation = rotation_about({1, 2, -1}, 0.31 * i);
        const std::vector<Rgb> texels = turned_lighting_texels(light, rotation);
        const Rgb found = sum_of(texels);
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(found[channel] / wanted[channel], 1, 1e-3) << i;
        Vec3d middle(0.0);
        for (std::size_t t = 0; t < texels.size(); ++t)
            if (texels[t].x > 1) middle += Vec3d(directions[t]) * double(texels[t].x);
        EXPECT_GT(middle.normalized().dot(rotation(from)), std::cos(0.75 * 1.41 / size)) << i;
    }
}

TEST(TurnedLight, SeparatesOnlyBrightTexels) {
    EXPECT_TRUE(turnable_light(environment([](const Vec3d& d) { return 1 + d.y; }), 16).bright.empty());
    const LatLongImage spots = environment([](const Vec3d& d) {
        return std::sin(40 * d.x) * std::sin(40 * d.y) * std::sin(40 * d.z) > 0.5 ? 5.0 : 0.1;
    });
    const TurnableLight light = turnable_light(spots, 32);
    EXPECT_GT(light.bright.size(), 100u);
    EXPECT_LE(light.bright.size(), light.radiance.size() / 8);
    EXPECT_LT(relative_rmse(turned_lighting_texels(light, Rotation()), lighting_texels(spots, 32)), 0.03);
}

}  // namespace
}  // namespace haarfield
