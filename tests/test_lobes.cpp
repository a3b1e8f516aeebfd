#include "shading/lobes.h"

#include <gtest/gtest.h>

#include <random>

namespace haarfield {
namespace {

std::vector<Vec3f> random_directions(int count) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    std::vector<Vec3f> directions;
    while (int(directions.size()) < count)
        directions.push_back(Vec3f(normal(random), normal(random), normal(random)).normalized());
    return directions;
}

std::vector<float> cubemap_texels(const CubemapTree& tree, int size) {
    std::vector<float> texels;
    for (const Quadtree& face : tree.faces)
        for (const float t : quadtree_texels(face, size)) texels.push_back(t);
    return texels;
}

/// int f dw over the sphere, of texels. [sr]
double sphere_integral(const std::vector<float>& texels, int size) {
    double sum = 0;
    std::size_t i = 0;
    for (int face = 0; face < 6; ++face)
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column)
                sum += texels[i++] * texel_solid_angle(column, row, size);
    return sum;
}

TEST(Lobes, TexelsIntegrateToTheClosedForm) {
    // int max(0, d.w)^n dw = 2 pi / (n + 1)
    for (const float exponent : {1.0f, 5.0f, 60.0f, 200.0f, 1000.0f})
        for (const Vec3f& d : random_directions(5))
            EXPECT_NEAR(sphere_integral(lobe_texels(exponent, d, 64), 64) * (exponent + 1) / (2 * pi), 1,
                        0.01)
                << exponent << " " << d;
}

TEST(Lobes, InterpolationKeepsEnergyAndShape) {
    for (const float exponent : {1.0f, 10.0f, 150.0f}) {
        const LobeTable table = *lobe_table(exponent, 32, {0});
        for (const Vec3f& d : random_directions(20)) {
            const std::vector<float> found = cubemap_texels(interpolated_lobe(table, d), 32),
                                     wanted = lobe_texels(exponent, d, 32);
            EXPECT_NEAR(sphere_integral(found, 32) / sphere_integral(wanted, 32), 1, 0.01) << exponent;
            double worst = 0;
            for (std::size_t i = 0; i < wanted.size(); ++i)
                worst = std::max(worst, std::abs(double(found[i]) - wanted[i]));
            EXPECT_LT(worst, 0.02) << exponent;
        }
    }
}

TEST(Lobes, TruncationKeepsTheEnergy) {
    const LobeTable table = *lobe_table(60, 32, {70});
    for (const Vec3f& d : random_directions(20))
        EXPECT_NEAR(sphere_integral(cubemap_texels(interpolated_lobe(table, d), 32), 32) * 61 / (2 * pi), 1,
                    0.02);
}

TEST(Lobes, LookupIsContinuousAcrossFaceBorders) {
    const LobeTable table = *lobe_table(20, 16, {0});
    std::vector<float> before;
    for (int i = 0; i <= 2000; ++i) {
        const double a = 2 * pi * i / 2000;  // a great circle through several faces
        const Vec3f d = Vec3f(float(std::cos(a)), float(std::sin(a) * 0.8), float(std::sin(a) * 0.6));
        const std::vector<float> now = cubemap_texels(interpolated_lobe(table, d), 16);
        for (std::size_t t = 0; t < before.size(); ++t) ASSERT_NEAR(now[t], before[t], 0.02) << "step " << i;
        before = now;
    }
}

TEST(HalfSpace, TexelsHoldTheAreaAboveThePlane) {
    const int size = 16, fine = 32;
    for (const Vec3f& n : random_directions(10)) {
        const std::vector<float> found = cubemap_texels(half_space_tree(n, size), size);
        std::size_t i = 0;
        for (int face = 0; face < 6; ++face)
            for (int row = 0; row < size; ++row)
                for (int column = 0; column < size; ++column) {
                    int above = 0;
                    for (int y = 0; y < fine; ++y)
                        for (int x = 0; x < fine; ++x)
                            above +=
                                texel_direction(face, column * fine + x, row * fine + y, size * fine).dot(n) >
                                0;
                    EXPECT_NEAR(found[i++], double(above) / (fine * fine), 0.02);
                }
    }
}

TEST(HalfSpace, CoversHalfOfTheSphere) {
    for (const Vec3f& n : random_directions(50))
        EXPECT_NEAR(sphere_integral(cubemap_texels(half_space_tree(n, 64), 64), 64) / (2 * pi), 1, 1e-3);
    const CubemapTree up = half_space_tree({0, 1, 0}, 64);
    EXPECT_EQ(up.faces[2].scaling, 1);
    EXPECT_EQ(up.faces[3].scaling, 0);
    EXPECT_NEAR(up.faces[0].scaling, 0.5, 1e-6);
}

}  // namespace
}  // namespace haarfield
