#include "fields/wavelets/cubemap.h"

#include "fields/base/spiral.h"

#include <OpenEXR/ImfEnvmap.h>
#include <gtest/gtest.h>

#include <vector>

namespace haarfield {
namespace {

const std::vector<Vec3d>& some_directions() {
    static const std::vector<Vec3d> directions = [] {
        std::vector<Vec3d> result;
        for (std::size_t i = 0; i < 2000; ++i)
            result.push_back(spiral_direction(i, 1 - 2 * (double(i) + 0.5) / 2000));
        return result;
    }();
    return directions;
}

/// OpenEXR's pixels are points, and the outermost ones are on the edges: with n of them along an edge,
/// position p is at u = 2 p / (n - 1) - 1. The same holds for its lat-long maps.
constexpr int points = 1025;
const Imath::Box2i cube_window(Imath::V2i(0, 0), Imath::V2i(points - 1, 6 * points - 1));
const Imath::Box2i lat_long_window(Imath::V2i(0, 0), Imath::V2i(2 * points - 1, points - 1));

TEST(Cubemap, FacesAreLaidOutAsOpenExrsAre) {
    for (const Vec3d& direction : some_directions()) {
        const CubemapPoint point = cubemap_point(direction);
        Imf::CubeMapFace face;
        Imath::V2f in_face;
        Imf::CubeMap::faceAndPixelPosition(Imath::V3f(direction), cube_window, face, in_face);
        // Its `in_face` is not oriented like the picture in its header, but positions in the image are.
        const Imath::V2f position = Imf::CubeMap::pixelPosition(face, cube_window, in_face) -
                                    Imath::V2f(Imf::CubeMap::dataWindowForFace(face, cube_window).min);
        ASSERT_EQ(point.face, int(face)) << direction;
        EXPECT_NEAR((point.u + 1) / 2 * (points - 1), position.x, 0.01)
            << direction << ", face " << point.face;
        EXPECT_NEAR((point.v + 1) / 2 * (points - 1), position.y, 0.01)
            << direction << ", face " << point.face;
    }
}

TEST(Cubemap, PointAndDirectionAreInverse) {
    for (const Vec3d& direction : some_directions()) {
        const CubemapPoint point = cubemap_point(direction * 3.7);
        EXPECT_LE(std::abs(point.u), 1);
        EXPECT_LE(std::abs(point.v), 1);
        const Vec3d back = cubemap_direction<Vec3d>(point.face, point.u, point.v);
        EXPECT_LT((back.normalized() - direction).length(), 1e-12) << direction;
    }
}

TEST(Cubemap, TexelsAreCentredBetweenTheirEdges) {
    for (const int size : {1, 2, 16, 64})
        for (int face = 0; face < cubemap_faces; ++face)
            for (int row = 0; row < size; row += 3)
                for (int column = 0; column < size; column += 5) {
                    const Vec3f direction = texel_direction(face, column, row, size);
                    EXPECT_NEAR(direction.length(), 1, 1e-6);
                    const CubemapPoint point = cubemap_point(Vec3d(direction));
                    EXPECT_EQ(point.face, face);
                    EXPECT_NEAR((point.u + 1) / 2 * size, column + 0.5, 1e-4);
                    EXPECT_NEAR((point.v + 1) / 2 * size, row + 0.5, 1e-4);
                }
}

TEST(Cubemap, SolidAnglesAreTheJacobiansIntegralAndAddUpToTheSphere) {
    for (int size = 1; size <= 256; size *= 4) {
        double sum = 0;
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column) sum += texel_solid_angle(column, row, size);
        EXPECT_NEAR(6 * sum, 4 * pi, 1e-10) << size;
    }
    for (const auto& [column, row, size] : {std::array{0, 0, 4}, {3, 1, 4}, {31, 32, 64}, {0, 63, 64}}) {
        double sum = 0;
        constexpr int grid = 200;
        for (int a = 0; a < grid; ++a)
            for (int b = 0; b < grid; ++b) {
                const double u = (column + (a + 0.5) / grid) * 2 / size - 1;
                const double v = (row + (b + 0.5) / grid) * 2 / size - 1;
                sum += std::pow(1 + u * u + v * v, -1.5);
            }
        const double expected = sum * 4 / (double(size) * size * grid * grid);
        EXPECT_NEAR(texel_solid_angle(column, row, size), expected, 1e-5 * expected) << column << ", " << row;
    }
}

TEST(LatLong, IsLaidOutAsOpenExrs) {
    for (const Vec3d& direction : some_directions()) {
        double x, y;
        lat_long_point(direction, x, y);
        const Imath::V2f position = Imf::LatLongMap::pixelPosition(lat_long_window, Imath::V3f(direction));
        EXPECT_NEAR(x * (2 * points - 1), position.x, 0.01) << direction;
        EXPECT_NEAR(y * (points - 1), position.y, 0.01) << direction;
    }
    for (const double x : {0.01, 0.3, 0.5, 0.77})
        for (const double y : {0.02, 0.4, 0.9}) {
            const Imath::V2f position(float(x * (2 * points - 1)), float(y * (points - 1)));
            const Vec3d theirs = Vec3d(Imf::LatLongMap::direction(lat_long_window, position));
            EXPECT_LT((theirs - lat_long_direction(x, y)).length(), 1e-5) << x << ", " << y;
        }
}

TEST(LatLong, PointAndDirectionAreInverse) {
    for (const Vec3d& direction : some_directions()) {
        double x, y;
        lat_long_point(direction * 0.1, x, y);
        EXPECT_GE(x, 0);
        EXPECT_LT(x, 1);
        EXPECT_GE(y, 0);
        EXPECT_LE(y, 1);
        EXPECT_LT((lat_long_direction(x, y) - direction).length(), 1e-12) << direction;
    }
}

TEST(LatLong, AxesAreWhereTheHeaderSays) {
    const auto expect_at = [](const Vec3d& direction, double x, double y) {
        EXPECT_LT((lat_long_direction(x, y) - direction).length(), 1e-12);
    };
    expect_at({0, 0, 1}, 0.5, 0.5);
    expect_at({1, 0, 0}, 0.25, 0.5);
    expect_at({-1, 0, 0}, 0.75, 0.5);
    expect_at({0, 0, -1}, 0, 0.5);
    expect_at({0, 1, 0}, 0.3, 0);
    expect_at({0, -1, 0}, 0.8, 1);
}

}  // namespace
}  // namespace haarfield
