#include "shading/scene/light_sources.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "shading/scene/sky.h"

namespace haarfield {
namespace {

constexpr int width = 128, height = 64;

LatLongImage even_image(float radiance = 0.5f) {
    return {width, height, std::vector<Rgb>(std::size_t(width * height), Rgb(radiance))};
}

Rgb& pixel(LatLongImage& image, int column, int row) {
    return image.pixels[std::size_t(row * image.width + (column + image.width) % image.width)];
}

/// Returns the total energy over all directions.
Vec3d energy(const LatLongImage& image) {
    Vec3d sum(0.0);
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        sum += Vec3d(image.pixels[i]) *
               lat_long_pixel_solid_angle(int(i) / image.width, image.width, image.height);
    return sum;
}
Vec3d energy(const std::vector<DirectionalLight>& lights) {
    Vec3d sum(0.0);
    for (const DirectionalLight& light : lights) sum += Vec3d(light.irradiance);
    return sum;
}
void expect_near(const Vec3d& found, const Vec3d& wanted, double relative, const char* what) {
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], wanted[c], relative * wanted[c]) << what << ", channel " << c;
}

/// Returns two lamps of one pixel each and a coloured sun of 3 x 2 pixels, in a uniform sky.
LatLongImage lamps_and_sun() {
    LatLongImage image = even_image();
    pixel(image, 20, 30) = pixel(image, 24, 30) = Rgb(900, 900, 700);
    for (int column = 70; column < 73; ++column)
        for (int row = 12; row < 14; ++row) pixel(image, column, row) = Rgb(3000, 2000, 1000);
    return image;
}

TEST(LightSources, KeepTheEnergyOfTheEnvironment) {
    const Environment environment{lamps_and_sun(), {{Vec3f(0, 1, 0), 0.01f, Rgb(2, 3, 4)}}};
    const SplitLight split = split_light(environment);
    ASSERT_EQ(split.sources.size(), 4u);
    Vec3d by_parts = energy(split.smooth), by_lights = by_parts;
    for (const LightSource& source : split.sources) {
        by_parts += energy(source.parts);
        by_lights += energy(source.lights);
    }
    const Vec3d wanted = energy(environment.image) + Vec3d(2, 3, 4);
    expect_near(by_parts, wanted, 1e-5, "parts");
    expect_near(by_lights, wanted, 1e-5, "lights");
}

TEST(LightSources, AreFoundAtFullSizeBeforeWideImagesAreReduced) {
    LatLongImage image{8192, 8, {}};
    for (int row = 0; row < image.height; ++row)
        for (int column = 0; column < image.width; ++column)
            image.pixels.emplace_back(0.5f + 0.1f * float((column / 3 + row) % 5), 0.4f, 0.3f);
    constexpr int at_column = 1001, at_row = 3;
    pixel(image, at_column, at_row) = Rgb(4e6f, 3e6f, 2e6f);
    const SplitLight split = split_light({image, {}});
    EXPECT_EQ(split.smooth.width, 4096);
    EXPECT_EQ(split.smooth.height, 4);
    ASSERT_EQ(split.sources.size(), 1u);
    const LightSource& source = split.sources[0];
    EXPECT_NEAR(source.solid_angle, lat_long_pixel_solid_angle(at_row, image.width, image.height), 1e-12);
    expect_near(energy(split.smooth) + energy(source.parts), energy(image), 1e-5, "all light");
    image.pixels[std::size_t(at_row * image.width + at_column)] = Rgb(0.5f, 0.4f, 0.3f);
    expect_near(energy(split.smooth), energy(image), 1e-4, "smooth light");
    for (const Rgb& left : split.smooth.pixels) EXPECT_LE(left.x, 0.91f);
}

TEST(LightSources, LeaveTheLevelOfTheirSurroundings) {
    const SplitLight split = split_light({lamps_and_sun(), {}});
    for (const Rgb& left : split.smooth.pixels)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(left[c], 0.5f, 1e-3f);
}

TEST(LightSources, AreSeparateRegionsWithTheirShares) {
    const LatLongImage image = lamps_and_sun();
    const SplitLight split = split_light({image, {}});
    ASSERT_EQ(split.sources.size(), 3u);  // from the top: the sun, then the lamps
    const auto light_of = [](const Vec3d& rgb) { return double(luminance(Rgb(Vec3f(rgb)))); };
    for (const LightSource& source : split.sources)
        EXPECT_NEAR(source.share, light_of(energy(source.parts)) / light_of(energy(image)), 1e-4);
    const std::array<std::array<double, 2>, 3> places{{{71.5, 13}, {20.5, 30.5}, {24.5, 30.5}}};
    for (std::size_t s = 0; s < 3; ++s) {
        const Vec3d middle = lat_long_direction(places[s][0] / width, places[s][1] / height);
        for (const DirectionalLight& light : split.sources[s].lights)
            EXPECT_GT(Vec3d(light.direction).dot(middle), std::cos(2 * 2 * pi / width)) << s;
    }
}

TEST(LightSources, AreWholeAcrossTheSeamAndThePole) {
    LatLongImage seam = even_image(), pole = even_image();
    for (int column = -2; column < 2; ++column) pixel(seam, column, 20) = Rgb(3000);
    for (int column : {10, 10 + width / 2})
        for (int row = 0; row < 3; ++row) pixel(pole, column, row) = Rgb(90000);
    EXPECT_EQ(split_light({seam, {}}).sources.size(), 1u);
    EXPECT_EQ(split_light({pole, {}}).sources.size(), 1u);
}

TEST(LightSources, AreNeitherFoundInEvenLightNorInFaintSparks) {
    const LatLongImage even = even_image();
    const SplitLight none = split_light({even, {}});
    EXPECT_TRUE(none.sources.empty());
    EXPECT_EQ(none.smooth.pixels, even.pixels);
    LatLongImage spark = even_image();
    pixel(spark, 5, 0) = Rgb(60);  // 120 times the mean, but one small pixel
    const SplitLight faint = split_light({spark, {}});
    EXPECT_TRUE(faint.sources.empty());
    EXPECT_EQ(faint.smooth.pixels, spark.pixels);
    EXPECT_TRUE(split_light({LatLongImage{width, height, std::vector<Rgb>(width * height, Rgb(0.0f))}, {}})
                    .sources.empty());
}

TEST(LightSources, AreDividedAsTheRuleRequires) {
    const Environment environment{even_image(), {{Vec3f(0.6f, 0.8f, 0), 0.02f, Rgb(1)}}};
    const double share = 1 / (4 * pi * 0.5 + 1), solid_angle = 2 * pi * (1 - std::cos(0.02));
    const auto count = [&](const SourceRule& rule) {
        return split_light(environment, rule).sources.at(0).lights.size();
    };
    EXPECT_EQ(count({.least_lights = 4, .fraction_per_light = 1, .solid_angle_of_a_light = 1}), 4u);
    EXPECT_EQ(count({.fraction_per_light = share / 9.5, .solid_angle_of_a_light = 1}), 10u);
    EXPECT_EQ(count({.fraction_per_light = 1, .solid_angle_of_a_light = solid_angle / 19.5}), 20u);
    EXPECT_EQ(count({.fraction_per_light = 1e-6, .most_lights = 33}), 33u);
    EXPECT_EQ(count({.fraction_per_light = 1e-6, .most_lights = 33, .direction_factor = 4}), 132u);
}

/// A low sun of one pixel at a straight edge: the penumbra spans the pixel, without large steps.
TEST(LightSources, APixelCastsThePenumbraOfItsArea) {
    LatLongImage image = even_image();
    pixel(image, 40, 28) = Rgb(9000);
    const SplitLight split = split_light({image, {}});
    ASSERT_EQ(split.sources.size(), 1u);
    const LightSource& sun = split.sources[0];
    const double whole = energy(sun.parts).x;
    // Edges in azimuth and in height: the fraction of the light on one side of each.
    for (int step = 1; step < 20; ++step) {
        const double along = step / 20.0;
        const auto fractions = [&](const std::vector<DirectionalLight>& lights) {
            Vec2f sides(0.0f);
            for (const DirectionalLight& light : lights) {
                double x = 0, y = 0;
                lat_long_point(Vec3d(light.direction), x, y);
                if (x * width < 40 + along) sides.x += float(double(light.irradiance.x) / whole);
                if (y * height < 28 + along) sides.y += float(double(light.irradiance.x) / whole);
            }
            return sides;
        };
        const Vec2f parts = fractions(sun.parts), lights = fractions(sun.lights);
        for (int axis = 0; axis < 2; ++axis) {
            EXPECT_NEAR(parts[axis], along, 0.04) << axis << " at " << along;
            EXPECT_NEAR(lights[axis], along, 0.1) << axis << " at " << along;
        }
    }
}

TEST(LightSources, DimPixelsStayWhole) {
    LatLongImage image = even_image(1e-3f);
    for (int column = 0; column < 100; ++column)
        for (int row = 30; row < 40; ++row) pixel(image, column, row) = Rgb(1);
    const SourceRule rule{.threshold = 1, .fraction_per_direction = 0.01, .solid_angle_per_direction = 1};
    EXPECT_EQ(split_light({image, {}}, rule).sources.at(0).parts.size(), 1000u);
}

TEST(LightSources, FewLightsApproximateManyParts) {
    std::vector<DirectionalLight> parts;
    for (int i = 0; i < 20; ++i)
        for (int k = 0; k < 5; ++k)
            parts.push_back({Vec3f(Vec3d(0.01 * i, 1, 0.01 * k).normalized()), Rgb(float(1 + i), 1, 0.5f)});
    for (const int count : {1, 2, 7, 50}) {
        const std::vector<DirectionalLight> few = reduced_lights(parts, count);
        EXPECT_EQ(few.size(), std::size_t(count));
        expect_near(energy(few), energy(parts), 1e-5, "few");
        for (const DirectionalLight& light : few) {
            EXPECT_NEAR(light.direction.length(), 1, 1e-6);
            EXPECT_GT(light.direction.x, -1e-6f);
            EXPECT_LT(light.direction.x, 0.2f);
        }
    }
    EXPECT_EQ(reduced_lights(parts, 1000).size(), parts.size());
    // Finer splits approximate the parts' irradiance on any plane better.
    const auto on_plane = [](const std::vector<DirectionalLight>& lights, const Vec3d& normal) {
        double sum = 0;
        for (const DirectionalLight& light : lights)
            sum += std::max(0.0, Vec3d(light.direction).dot(normal)) * double(light.irradiance.x);
        return sum;
    };
    const Vec3d grazing = Vec3d(1, -0.1, 0).normalized();
    const double exact = on_plane(parts, grazing);
    EXPECT_GT(std::abs(on_plane(reduced_lights(parts, 1), grazing) - exact), 0.02 * exact);
    EXPECT_NEAR(on_plane(reduced_lights(parts, 25), grazing), exact, 0.01 * exact);
}

TEST(SunDisc, IsCoveredEvenly) {
    const SunDisc disc{Vec3f(Vec3d(0.3, -0.5, 0.7).normalized()), 0.05f, Rgb(1)};
    for (const int count : {1, 16, 1000}) {
        const std::vector<Vec3f> directions = disc_directions(disc, count);
        ASSERT_EQ(directions.size(), std::size_t(count));
        Vec3d mean(0.0);
        int inner = 0;
        for (const Vec3f& direction : directions) {
            EXPECT_NEAR(direction.length(), 1, 1e-6);
            const double angle = std::acos(std::min(1.0, Vec3d(direction).dot(Vec3d(disc.direction))));
            EXPECT_LT(angle, 0.0501);
            inner += angle < 0.05 / std::sqrt(2.0);
            mean += Vec3d(direction) / count;
        }
        EXPECT_NEAR(inner, count / 2.0, count == 1 ? 0.6 : 0.03 * count + 1);
        EXPECT_LT((mean.normalized() - Vec3d(disc.direction)).length(),
                  count == 1 ? 0.036 : 0.3 * 0.05 / std::sqrt(double(count)) + 1e-4);
    }
}

TEST(SunDisc, TurnsAndBrightensWithItsEnvironment) {
    const Environment turned =
        turned_environment(Environment{even_image(), {{Vec3f(0, 0, 1), 0.01f, Rgb(1)}}}, pi / 2, 1);
    EXPECT_LT((turned.suns[0].direction - Vec3f(1, 0, 0)).length(), 1e-6f);  // as in the image: +z maps to +x
    EXPECT_EQ(turned.suns[0].irradiance, Rgb(2));
    EXPECT_EQ(turned.image.pixels[0], Rgb(1));
}

TEST(SunDisc, KeepsItsEnergyInAnImage) {
    const Environment environment{even_image(0),
                                  {{Vec3f(Vec3d(0.2, 0.6, -0.4).normalized()), 0.00465f, Rgb(3, 2, 1)}}};
    expect_near(energy(image_with_suns(environment)), Vec3d(3, 2, 1), 1e-4, "image");
}

TEST(SkyEnvironment, IsTheSkyImageWithASeparateSun) {
    for (const double elevation : {0.0, 5.0, 40.0}) {
        AnalyticSky sky;
        sky.sun_elevation = float(elevation * pi / 180);
        const Environment parted = sky_environment(sky, 512);
        ASSERT_EQ(parted.suns.size(), 1u);
        EXPECT_LT((parted.suns[0].direction -
                   Vec3f(Vec3d(std::cos(elevation * pi / 180) * std::cos(double(sky.sun_azimuth)),
                               std::sin(elevation * pi / 180),
                               std::cos(elevation * pi / 180) * std::sin(double(sky.sun_azimuth)))))
                      .length(),
                  1e-5f);
        expect_near(energy(image_with_suns(parted)), energy(sky_image(sky, 512)), 0.01, "sky");
        float brightest = 0;
        for (const Rgb& p : parted.image.pixels) brightest = std::max(brightest, luminance(p));
        EXPECT_LT(brightest, 30);  // contains no sun
    }
}

}  // namespace
}  // namespace haarfield
