#include "bridge/povray_import/surface_charts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace haarfield {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// A sheet that rolls up three times along a spiral: its projections overlap.
struct Roll {
    std::vector<Vec3f> positions;
    Triangles triangles;

    Roll() {
        constexpr std::uint32_t around = 120, along = 6;
        for (std::uint32_t i = 0; i <= around; ++i)
            for (std::uint32_t j = 0; j <= along; ++j) {
                const float angle = float(i) / 40 * 6.2831853f, radius = 1 + float(i) / 200;
                positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), float(j) / 4);
            }
        for (std::uint32_t i = 0; i < around; ++i)
            for (std::uint32_t j = 0; j < along; ++j) {
                const std::uint32_t a = i * (along + 1) + j, b = a + along + 1;
                triangles.push_back({a, b, b + 1});
                triangles.push_back({a, b + 1, a + 1});
            }
    }
};

double area(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
    return 0.5 * double((b - a).cross(c - a).length());
}

double signed_area(const Vec2f& a, const Vec2f& b, const Vec2f& c) {
    return 0.5 * double((b - a).cross(c - a));
}

/// Returns the texels whose centres are inside a triangle of image coordinates, with a margin.
std::vector<std::pair<int, int>> texels(const std::array<Vec2f, 3>& uv, int width, int height) {
    std::vector<std::pair<int, int>> result;
    const double whole = signed_area(uv[0], uv[1], uv[2]);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Vec2f p((float(x) + 0.5f) / float(width), 1 - (float(y) + 0.5f) / float(height));
            bool is_inside = true;
            for (std::size_t k = 0; k < 3; ++k)
                is_inside = is_inside && signed_area(uv[k], uv[(k + 1) % 3], p) / whole > 0.2;
            if (is_inside) result.emplace_back(x, y);
        }
    return result;
}

TEST(SurfaceCharts, TrianglesDoNotOverlapAndKeepTheirSize) {
    const Roll roll;
    constexpr float size = 0.04f;
    const UnchartedSurface surface{roll.positions, roll.triangles,
                                   std::vector<float>(roll.triangles.size(), size)};
    const SurfaceCharts charts = surface_charts(std::span(&surface, 1), 1e6);
    ASSERT_EQ(charts.surfaces.size(), 1u);
    const ChartedSurface& charted = charts.surfaces[0];
    ASSERT_EQ(charted.triangles.size(), roll.triangles.size());
    ASSERT_EQ(charted.originals.size(), charted.uvs.size());
    ASSERT_EQ(charts.covered.size(), std::size_t(charts.width) * std::size_t(charts.height));
    std::set<std::pair<int, int>> taken;
    const double texel = 1.0 / (double(charts.width) * double(charts.height));
    for (std::size_t t = 0; t < roll.triangles.size(); ++t) {
        std::array<Vec2f, 3> uv;
        std::array<Vec3f, 3> p;
        for (std::size_t c = 0; c < 3; ++c) {
            const std::uint32_t v = charted.triangles[t][c];
            EXPECT_EQ(charted.originals[v], roll.triangles[t][c]);
            uv[c] = charted.uvs[v];
            p[c] = roll.positions[roll.triangles[t][c]];
            for (int axis = 0; axis < 2; ++axis) {
                EXPECT_GT(uv[c][axis], 0.0f);
                EXPECT_LT(uv[c][axis], 1.0f);
            }
        }
        const double found = std::abs(signed_area(uv[0], uv[1], uv[2])) / texel,
                     flat = area(p[0], p[1], p[2]) / double(size * size);
        EXPECT_LE(found, flat * 1.001);
        EXPECT_GE(found, flat / std::sqrt(3.0) * 0.999);
        for (const auto& place : texels(uv, charts.width, charts.height)) {
            EXPECT_TRUE(taken.insert(place).second) << place.first << ' ' << place.second;
            EXPECT_TRUE(charts.covered[std::size_t(place.second) * std::size_t(charts.width) +
                                       std::size_t(place.first)]);
        }
    }
    EXPECT_GT(taken.size(), 500u);
}

TEST(SurfaceCharts, RectanglesAreDisjointAndHaveABorder) {
    const Roll roll;
    std::vector<float> sizes(roll.triangles.size(), 0.05f);
    for (std::size_t t = 0; t < sizes.size() / 2; ++t) sizes[t] = 0.2f;
    const std::vector<UnchartedSurface> surfaces(2, {roll.positions, roll.triangles, sizes});
    const SurfaceCharts charts = surface_charts(surfaces, 1e6);
    std::vector<int> uses(charts.covered.size());
    for (const ChartRectangle& chart : charts.rectangles)
        for (int y = chart.top; y < chart.top + chart.height; ++y)
            for (int x = chart.left; x < chart.left + chart.width; ++x) {
                const std::size_t place = std::size_t(y) * std::size_t(charts.width) + std::size_t(x);
                ++uses[place];
                const bool is_border = x < chart.left + 2 || y < chart.top + 2 ||
                                       x >= chart.left + chart.width - 2 || y >= chart.top + chart.height - 2;
                EXPECT_FALSE(is_border && charts.covered[place]);
            }
    for (std::size_t i = 0; i < uses.size(); ++i) {
        EXPECT_LE(uses[i], 1);
        if (charts.covered[i]) {
            EXPECT_EQ(uses[i], 1);
        }
    }
}

TEST(SurfaceCharts, TooManyTexelsBecomeLarger) {
    const Roll roll;
    const UnchartedSurface surface{roll.positions, roll.triangles,
                                   std::vector<float>(roll.triangles.size(), 0.001f)};
    const SurfaceCharts charts = surface_charts(std::span(&surface, 1), 5000);
    const auto covered = std::ranges::count(charts.covered, std::uint8_t(1));
    EXPECT_LT(covered, 5000);
    EXPECT_GT(covered, 2000);
}

}  // namespace
}  // namespace haarfield
