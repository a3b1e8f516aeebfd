#include "shading/bounces/cosine_directions.h"

#include <gtest/gtest.h>

#include <set>

namespace haarfield {
namespace {

TEST(CosineDirections, SobolPointsFillEachOthersGaps) {
    // Each box of 2^-k by 2^(k-m) contains one of 2^m points that start at a multiple of 2^m.
    for (const std::uint32_t first : {0u, 64u, 4096u, 181'440u})
        for (int across = 0; across <= 6; ++across) {
            std::set<std::pair<int, int>> boxes;
            for (std::uint32_t i = 0; i < 64; ++i) {
                const Vec2f p = sobol_point(first + i);
                ASSERT_TRUE(p.x >= 0 && p.x < 1 && p.y >= 0 && p.y < 1);
                boxes.emplace(int(p.x * float(1 << across)), int(p.y * float(1 << (6 - across))));
            }
            EXPECT_EQ(boxes.size(), 64u) << "from " << first << ", columns " << (1 << across);
        }
}

/// Returns the mean over 4096 directions of a power of their cosine with the axis.
template <class DirectionOf>
double mean_power(const DirectionOf& direction_of, const Vec3f& axis, double power) {
    double sum = 0;
    for (std::uint32_t i = 0; i < 4096; ++i) {
        const Vec3f direction = direction_of(sobol_point(i));
        EXPECT_NEAR(direction.length(), 1, 1e-5);
        EXPECT_GE(direction.dot(axis), -1e-6f);
        sum += std::pow(std::max(0.0, double(direction.dot(axis))), power) / 4096;
    }
    return sum;
}

TEST(CosineDirections, HaveTheDensityOfTheCosine) {
    const Vec3f normal = Vec3f(1, -2, 0.5f).normalized();
    const Axes<Vec3f> axes = axes_across(normal);
    const auto direction = [&](const Vec2f& p) { return cosine_direction(p, normal, axes); };
    for (const double power : {1.0, 2.0, 5.0})  // int cos^n cos/pi dw = 2 / (n + 2)
        EXPECT_NEAR(mean_power(direction, normal, power), 2 / (power + 2), 1e-3) << power;
    Vec3d mean(0.0);
    for (std::uint32_t i = 0; i < 4096; ++i) mean += Vec3d(direction(sobol_point(i))) / 4096.0;
    EXPECT_NEAR((mean - Vec3d(normal) * (2.0 / 3)).length(), 0, 1e-3);
}

TEST(CosineDirections, HaveTheDensityOfALobe) {
    const Vec3f axis = Vec3f(0.2f, 0.3f, -1).normalized();
    const Axes<Vec3f> axes = axes_across(axis);
    for (const float exponent : {1.0f, 20.0f, 300.0f}) {
        const auto direction = [&](const Vec2f& p) { return power_direction(p, exponent, axis, axes); };
        for (const double power : {1.0, 30.0})  // (n + 1) / (n + m + 1)
            EXPECT_NEAR(mean_power(direction, axis, power), (exponent + 1) / (exponent + power + 1), 1e-3)
                << exponent << ", " << power;
    }
}

}  // namespace
}  // namespace haarfield
