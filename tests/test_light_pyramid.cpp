#include "shading/walk/light_pyramid.h"

#include <gtest/gtest.h>

#include "fields/wavelets/haar_transform.h"
#include "shading/walk/cell_path.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

RgbCubemapTree random_light(std::uint32_t seed, int levels) {
    RgbCubemapTree light;
    for (std::uint32_t face = 0; face < cubemap_faces; ++face)
        light.faces[face] = reference::random_rgb_quadtree(seed + face, levels, 0.7);
    return light;
}

/// Returns the mean over a square of a face of the lighting times the unit vectors towards it, for one
/// channel, over 4 x 4 points in each texel.
Vec3d mean_moment(std::span<const Rgb> texels, int size, int face, SquarePlace square, int squares,
                  int channel) {
    const int side = size / squares, steps = 4;
    Vec3d sum(0.0);
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const int x = int(square.column) * side + column, y = int(square.row) * side + row;
            const double light = texels[std::size_t(y * size + x)][channel];
            for (int k = 0; k < steps * steps; ++k) {
                const double u = (x + (k % steps + 0.5) / steps) / size * 2 - 1,
                             v = (y + (k / steps + 0.5) / steps) / size * 2 - 1;
                sum += cubemap_direction<Vec3d>(face, u, v).normalized() * light;
            }
        }
    return sum / double(side * side * steps * steps);
}

TEST(LightPyramid, HasTheMomentsOfLightAboutTheMiddleOfTheSphere) {
    for (const int levels : {4, 6}) {
        const int size = 1 << levels;
        const RgbCubemapTree tree = random_light(5, levels);
        const LightPyramid light(tree, size);
        for (int level = 0; level + 1 < light.numbers().levels(); ++level)
            for (int face = 0; face < cubemap_faces; ++face) {
                const std::vector<Rgb> texels = quadtree_texels(tree.faces[std::size_t(face)], size);
                for (std::size_t path = 0; path < std::size_t(16) << (4 * level); path += 5)
                    for (int channel = 0; channel < 3; ++channel) {
                        const Vec3d wanted =
                            mean_moment(texels, size, face, square_place(path), 4 << (2 * level), channel);
                        const LightMoments::Channel& found =
                            light.moments(light.numbers()(level, std::size_t(face), path / wide_cells))
                                .channel[std::size_t(channel)];
                        const std::size_t cell = path % wide_cells;
                        EXPECT_NEAR(found.x[cell], wanted.x, 2e-4);
                        EXPECT_NEAR(found.y[cell], wanted.y, 2e-4);
                        EXPECT_NEAR(found.z[cell], wanted.z, 2e-4);
                    }
            }
    }
}

TEST(LightPyramid, IsUnevenWhereItVariesOnTheFirstLevelAndBelowWhereItIsConcentrated) {
    constexpr int size = 64;
    std::vector<Rgb> texels(std::size_t(cubemap_faces) * size * size, Rgb(1.0f));
    const std::size_t face_texels = std::size_t(size) * size;
    texels[2 * face_texels + 3 * size + 5] = Rgb(900.0f);  // the sun
    texels[3 * face_texels + 3 * size + 5] = Rgb(2.0f);    // not a sun
    const LightPyramid light(haar_cubemap<Rgb>(texels, size, {}), size);
    const BlockNumbers& numbers = light.numbers();
    for (int level = 0; level < 2; ++level)
        for (std::size_t block = numbers(level, 0, 0); block < numbers(level, 6, 0); ++block) {
            const bool has_sun = block == numbers(level, 2, 0),
                       has_speck = level == 0 && block == numbers(0, 3, 0);
            EXPECT_EQ(std::popcount(light.uneven(block)), has_sun || has_speck ? 1 : 0) << block;
        }
    EXPECT_EQ(std::popcount(light.varying(numbers(1, 3, 0))), 1);
}

}  // namespace
}  // namespace haarfield
