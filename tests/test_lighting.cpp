#include "shading/scene/lighting.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <cmath>

#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

LatLongImage black_image(int width) {
    const int height = width / 2;
    return {width, height, std::vector<Rgb>(std::size_t(width) * std::size_t(height), Rgb(0.0f))};
}

LatLongImage noise_image(int width, std::uint32_t seed) {
    LatLongImage image = black_image(width);
    const auto values = reference::noise_texels(seed, 3 * image.pixels.size());
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = Rgb(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    return image;
}

/// Returns the integral of the lighting over the sphere.
Vec3d energy(const std::vector<Rgb>& texels) {
    Vec3d sum(0, 0, 0);
    for (const Rgb& texel : texels) sum += Vec3d(texel);
    return sum * 6.0 / double(texels.size());
}

/// Adds bright pixels `across` x `across` from a corner on, wrapped in x. Returns their energy.
double add_sun(LatLongImage& image, int column, int row, int across) {
    double sun = 0;
    for (int y = row; y < std::min(row + across, image.height); ++y)
        for (int x = column; x < column + across; ++x) {
            image.pixels[std::size_t(y * image.width + x % image.width)] = Rgb(1e5f, 1e4f, 1e3f);
            sun += 1e5 * lat_long_pixel_solid_angle(y, image.width, image.height);
        }
    return sun;
}

TEST(Lighting, KeepsTheEnergyOfASunOfOneToNinePixelsAnywhere) {
    for (const int width : {64, 256, 1024})
        for (const int size : {16, 64, 256}) {
            const int suns = size == 256 ? (width == 1024 ? 1 : 2) : (width == 1024 ? 3 : 12);
            for (int i = 0; i < suns; ++i) {
                LatLongImage image = black_image(width);
                // Everywhere in the image; every third one at a pole.
                const int row = i % 3 == 0 ? (i % 2 == 0 ? 0 : width / 2 - 3) : (i * 7919 + 3) % (width / 2);
                const int across = 1 + i % 3;
                const double sun = add_sun(image, (i * 104729 + width - 1) % width, row, across);
                const Vec3d sum = energy(lighting_texels(image, size));
                EXPECT_NEAR(sum.x, sun, 1e-5 * sun)
                    << "width " << width << ", size " << size << ", row " << row;
                EXPECT_NEAR(sum.y, sun / 10, 1e-6 * sun);
                EXPECT_NEAR(sum.z, sun / 100, 1e-7 * sun);
            }
        }
}

TEST(Lighting, OfAConstantIsTheSolidAngle) {
    for (const int width : {2, 6, 64, 130, 512})
        for (const int size : {1, 2, 4, 16, 64}) {
            LatLongImage image = black_image(width);
            for (Rgb& pixel : image.pixels) pixel = Rgb(2, 1, 0.5f);
            const std::vector<Rgb> texels = lighting_texels(image, size);
            ASSERT_EQ(texels.size(), std::size_t(6 * size * size));
            for (int i = 0; i < 6 * size * size; ++i) {
                const double expected = texel_solid_angle(i % size, i / size % size, size) * size * size;
                for (int channel = 0; channel < 3; ++channel)
                    EXPECT_NEAR(texels[std::size_t(i)][channel], expected * std::ldexp(1.0, 1 - channel),
                                1e-5 * expected)
                        << "width " << width << ", size " << size << ", texel " << i;
            }
        }
}

TEST(Lighting, EqualsTheMeanOverManyDirectionsInEveryTexel) {
    // The reference: each texel is the mean of the pixels that a grid of directions in it hits.
    for (const auto& [width, size] : {std::pair(8, 4), {32, 8}, {50, 16}, {64, 2}}) {
        const LatLongImage image = noise_image(width, std::uint32_t(width));
        const std::vector<Rgb> texels = lighting_texels(image, size);
        constexpr int grid = 150;
        for (int i = 0; i < 6 * size * size; i += 7) {
            const int column = i % size, row = i / size % size, face = i / (size * size);
            double sum = 0;
            for (int a = 0; a < grid; ++a)
                for (int b = 0; b < grid; ++b) {
                    const double u = (column + (a + 0.5) / grid) * 2 / size - 1;
                    const double v = (row + (b + 0.5) / grid) * 2 / size - 1;
                    double x, y;
                    lat_long_point(cubemap_direction<Vec3d>(face, u, v), x, y);
                    const int pixel =
                        std::min(int(y * image.height), image.height - 1) * width + int(x * width);
                    // dw = 4 / (1 + u^2 + v^2)^1.5 of the face's area.
                    sum += double(image.pixels[std::size_t(pixel)].x) * 4 / std::pow(1 + u * u + v * v, 1.5);
                }
            EXPECT_NEAR(texels[std::size_t(i)].x, sum / (grid * grid), 0.015)
                << "width " << width << ", size " << size << ", face " << face << ", column " << column
                << ", row " << row;
        }
    }
}

TEST(Lighting, PutsABrightPixelWhereItsDirectionPoints) {
    // Pixels next to each axis, on both sides of it, would reveal a flip, a rotation or swapped faces.
    const int width = 512, size = 16;
    for (const Vec3d& axis :
         {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, -1, 0), Vec3d(0, 0, 1), Vec3d(0, 0, -1)})
        for (const Vec3d& offset :
             {Vec3d(0.31, 0.19, 0.05), Vec3d(-0.07, 0.43, -0.31), Vec3d(0.19, -0.07, 0.57)}) {
            const Vec3d wanted = (axis + offset).normalized();
            double x, y;
            lat_long_point(wanted, x, y);
            LatLongImage image = black_image(width);
            const int column = int(x * width), row = int(y * width / 2);
            image.pixels[std::size_t(row * width + column)] = Rgb(1.0f);
            const Vec3d centre = lat_long_direction((column + 0.5) / width, (row + 0.5) / (width / 2));
            const CubemapPoint point = cubemap_point(centre);
            const std::vector<Rgb> texels = lighting_texels(image, size);
            std::size_t brightest = 0;
            for (std::size_t i = 0; i < texels.size(); ++i)
                if (texels[i].x > texels[brightest].x) brightest = i;
            const int expected =
                (point.face * size + int((point.v + 1) / 2 * size)) * size + int((point.u + 1) / 2 * size);
            EXPECT_EQ(int(brightest), expected) << "direction " << wanted;
        }
}

TEST(Lighting, OfTheUpperHemisphereIsTheUpperHalf) {
    LatLongImage image = black_image(128);
    for (std::size_t i = 0; i < image.pixels.size() / 2; ++i) image.pixels[i] = Rgb(1.0f);
    const int size = 32;
    const std::vector<Rgb> texels = lighting_texels(image, size);
    for (int i = 0; i < 6 * size * size; ++i) {
        const int column = i % size, row = i / size % size, face = i / (size * size);
        const bool lit = texel_direction(face, column, row, size).y > 0;
        const double expected = lit ? texel_solid_angle(column, row, size) * size * size : 0;
        EXPECT_NEAR(texels[std::size_t(i)].x, expected, 1e-5) << face << ", " << column << ", " << row;
    }
    // Irradiance of a horizontal surface under it: pi.
    double irradiance = 0;
    for (int i = 0; i < 6 * size * size; ++i)
        irradiance += double(texels[std::size_t(i)].x) *
                      double(texel_direction(i / (size * size), i % size, i / size % size, size).y);
    EXPECT_NEAR(irradiance / (size * size), pi, 1e-3 * pi);
}

TEST(Lighting, ConservesTheEnergyOfTheWholeImage) {
    for (const int width : {6, 64, 250}) {
        const LatLongImage image = noise_image(width, 9);
        Vec3d expected(0, 0, 0);
        for (int i = 0; i < int(image.pixels.size()); ++i)
            expected += Vec3d(image.pixels[std::size_t(i)]) *
                        lat_long_pixel_solid_angle(i / width, width, image.height);
        for (const int size : {1, 8, 64}) {
            const Vec3d sum = energy(lighting_texels(image, size));
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(sum[channel], expected[channel], 1e-6 * expected[channel])
                    << width << ", " << size;
        }
    }
}

TEST(Lighting, HasTheSameBitsForAnyNumberOfThreads) {
    const LatLongImage image = noise_image(128, 5);
    const std::vector<Rgb> parallel = lighting_texels(image, 32);
    const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(lighting_texels(image, 32), parallel);
}

TEST(Lighting, AsTreesAddsUpToTheSphereIntegral) {
    const LatLongImage image = noise_image(64, 6);
    const std::vector<Rgb> texels = lighting_texels(image, 16);
    const RgbCubemapTree tree = lighting_tree(image, 16, {});
    Vec3d means(0, 0, 0);
    for (const RgbQuadtree& face : tree.faces) means += Vec3d(face.scaling);
    const Vec3d expected = energy(texels);
    for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(means[channel], expected[channel], 1e-5);
}

}  // namespace
}  // namespace haarfield
