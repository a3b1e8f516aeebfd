#include "scenes/shape.h"

#include <gtest/gtest.h>

#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/random_numbers.h"

namespace haarfield {
namespace {

using Rows = std::array<Vec3d, 3>;

Vec3d times(const Rows& m, const Vec3d& v) {
    return {m[0].dot(v), m[1].dot(v), m[2].dot(v)};
}

Rows product(const Rows& a, const Rows& b) {
    Rows result;
    for (std::size_t i = 0; i < 3; ++i) result[i] = b[0] * a[i].x + b[1] * a[i].y + b[2] * a[i].z;
    return result;
}

double determinant(const Rows& m) {
    return m[0].dot(m[1].cross(m[2]));
}

Rows diagonal(double x, double y, double z) {
    return {Vec3d(x, 0, 0), Vec3d(0, y, 0), Vec3d(0, 0, z)};
}

Rotation random_rotation(std::mt19937& random) {
    return rotation_about(Vec3d(random_direction(random)), uniform(random, 0.0, 2 * pi));
}

/// Returns a random map: scales by `least` to 1 along random axes, mirrors or not, rotates and scales
/// uniformly.
Rows random_map(std::mt19937& random, double least) {
    const Rotation axes = random_rotation(random);
    const Rows stretched =
        product(diagonal(1, uniform(random, least, 1.0), random() % 2 ? least : -least), axes.row);
    const double scale = std::exp(uniform(random, -4.0, 4.0));
    return product(diagonal(scale, scale, scale), product(random_rotation(random).row, stretched));
}

TEST(Shape, WithItsPlacementIsTheMap) {
    std::mt19937 random(1);
    for (const double least : {1.0, 0.9999, 0.5, 0.01, 1.01e-4})
        for (int trial = 0; trial < 200; ++trial) {
            const Rows map = random_map(random, least);
            const Result<PlacedShape> parts = placed_shape(map);
            ASSERT_TRUE(parts) << parts.error().message();
            const auto& [placement, shape] = *parts;
            EXPECT_EQ(placement.translate, Vec3f(0, 0, 0));
            EXPECT_NEAR(determinant(placement.rotate.row), 1, 1e-12);
            for (int k = 0; k < 20; ++k) {
                const Vec3d v(random_direction(random)), wanted = times(map, v),
                                                         found = placement.point_to_world(shape(v));
                EXPECT_LT((found - wanted).length(), 2e-7 * double(placement.scale)) << least;
                EXPECT_NEAR(placement.rotate(v).length(), 1, 1e-6) << "orthonormal";
                EXPECT_LE(shape(v).length(), 1 + 1e-6) << "magnifies nothing";
            }
            // A shape contains no rotation: without the mirror, it is symmetric and positive definite.
            const Rows unmirrored = product(shape.row, diagonal(determinant(shape.row) < 0 ? -1 : 1, 1, 1));
            EXPECT_EQ(determinant(shape.row) < 0, determinant(map) < 0);
            for (std::size_t i = 0; i < 3; ++i)
                for (int k = 0; k < 3; ++k) EXPECT_EQ(unmirrored[i][k], unmirrored[std::size_t(k)][int(i)]);
            const Vec3d v(random_direction(random));
            EXPECT_GT(times(unmirrored, v).dot(v), 0);
        }
}

TEST(Shape, DoesNotDependOnSubsequentRotationAndScale) {
    std::mt19937 random(2);
    for (const double least : {0.7, 0.1, 2e-4})
        for (int trial = 0; trial < 200; ++trial) {
            const Rows map = random_map(random, least);
            const double scale = uniform(random, 0.1, 10.0);
            const Rows turned =
                product(diagonal(scale, scale, scale), product(random_rotation(random).row, map));
            const Shape shape = placed_shape(map)->shape;
            EXPECT_TRUE(is_same_shape(placed_shape(turned)->shape, shape)) << least;
            EXPECT_FALSE(is_same_shape(shape, Shape()));
            EXPECT_FALSE(is_same_shape(placed_shape(product(map, diagonal(1, 1, 1.001)))->shape, shape));
            EXPECT_FALSE(is_same_shape(placed_shape(product(diagonal(-1, 1, 1), map))->shape, shape))
                << "mirrored";
        }
}

TEST(Shape, IsTheIdentityForUniformScale) {
    for (const double scale : {1e-6, 0.1, 1.0 / 3, 0.7, 1.0, 2.0, 123.456, 1e6}) {
        const Result<PlacedShape> parts = placed_shape(diagonal(scale, scale, scale));
        ASSERT_TRUE(parts) << parts.error().message();
        EXPECT_EQ(parts->placement, (Placement{{0, 0, 0}, static_cast<float>(scale)}));
        EXPECT_EQ(parts->shape, Shape());
        const Result<PlacedShape> half_turn = placed_shape(diagonal(-scale, -scale, scale));
        EXPECT_EQ(half_turn->placement.scale, static_cast<float>(scale));
        EXPECT_EQ(half_turn->placement.rotate.row, diagonal(-1, -1, 1));
        EXPECT_EQ(half_turn->shape, Shape());
    }
    // As files have them, with six digits.
    std::mt19937 random(3);
    for (int trial = 0; trial < 200; ++trial) {
        Rows turned = random_rotation(random).row;
        for (Vec3d& row : turned)
            for (int k = 0; k < 3; ++k) row[k] = std::round(row[k] * 1e6) / 1e6;
        EXPECT_EQ(placed_shape(turned)->shape, Shape());
    }
}

TEST(Shape, IsTheSameForAllMirrorsWithUniformScale) {
    std::mt19937 random(4);
    for (int trial = 0; trial < 200; ++trial) {
        const Rows mirrored = product(
            random_rotation(random).row,
            product(diagonal(1, -2.5, 1), product(diagonal(2.5, 1, 2.5), random_rotation(random).row)));
        EXPECT_EQ(placed_shape(mirrored)->shape.row, diagonal(-1, 1, 1));
    }
    EXPECT_EQ(placed_shape(diagonal(-3, -3, -3))->shape.row, diagonal(-1, 1, 1));
}

TEST(Shape, FactorsAreRelativeToTheLargest) {
    for (const double x : {2.0, -2.0})
        for (const double y : {0.5, -0.5})
            for (const double z : {1.0, -1.0}) {
                const Result<PlacedShape> parts = placed_shape(diagonal(x, y, z));
                EXPECT_EQ(parts->placement.scale, 2);
                EXPECT_EQ(parts->shape.row, diagonal(x * y * z < 0 ? -1 : 1, 0.25, 0.5));
            }
}

TEST(Shape, NamesDifferAsShapesDo) {
    const std::string name = shape_name(placed_shape(diagonal(2, 0.5, 1))->shape);
    EXPECT_EQ(name.size(), 8u);
    EXPECT_EQ(name.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_EQ(shape_name(placed_shape(diagonal(4, 1, 2))->shape), name);
    EXPECT_EQ(shape_name(placed_shape(diagonal(2, -0.5, -1))->shape), name);
    for (const Rows& other : {diagonal(-2, 0.5, 1), diagonal(0.5, 2, 1), diagonal(2, 0.5, 1.001)})
        EXPECT_NE(shape_name(placed_shape(other)->shape), name);
}

TEST(Shape, RefusesSingularMapsAndNan) {
    const Rows singular{Vec3d(1, 2, 3), Vec3d(2, 4, 6), Vec3d(1, 0, 0)};
    for (const Rows& bad : {singular, diagonal(0, 0, 0), diagonal(1, 0.9e-4, 1), diagonal(1.1e6, 1, 1e3),
                            diagonal(1e-3, 1e-3, 0.9e-6), diagonal(NAN, 1, 1), diagonal(INFINITY, 1, 1)}) {
        const Result<PlacedShape> parts = placed_shape(bad);
        ASSERT_FALSE(parts) << bad[0] << bad[1] << bad[2];
        EXPECT_NE(parts.error().what.find("expected 1e-06 to 1e+06, the largest at most 10000 times"),
                  std::string::npos)
            << parts.error().what;
    }
    EXPECT_TRUE(placed_shape(diagonal(1, 1.01e-4, -1)));
}

TEST(Shape, TheIdentityLeavesAMeshUnchanged) {
    const Mesh mesh = sphere_mesh({0.1f, 0.2f, 0.3f}, 1, 6), same = shaped_mesh(mesh, Shape());
    EXPECT_EQ(same.positions, mesh.positions);
    EXPECT_EQ(same.normals, mesh.normals);
    EXPECT_EQ(same.triangles, mesh.triangles);
}

double volume(const Mesh& mesh) {
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles)
        sum += Vec3d(mesh.positions[a]).dot(Vec3d(mesh.positions[b]).cross(Vec3d(mesh.positions[c]))) / 6;
    return sum;
}

TEST(Shape, TurnsNormalsAndTrianglesAsTheSurface) {
    std::mt19937 random(5);
    for (int trial = 0; trial < 40; ++trial) {
        const Shape shape = placed_shape(random_map(random, 0.2))->shape;
        // A sphere becomes an ellipsoid: its normal is what the two tangents, moved along numerically, leave.
        const Mesh sphere = sphere_mesh({0, 0, 0}, 1, 8), ellipsoid = shaped_mesh(sphere, shape);
        for (std::size_t v = 0; v < sphere.positions.size(); ++v) {
            const Vec3d p(sphere.normals[v]);
            const auto [across, up] = axes_across(p);
            const auto moved = [&](const Vec3d& tangent, double step) {
                return shape((p + tangent * step).normalized());
            };
            const double step = 1e-4;
            Vec3d normal = (moved(across, step) - moved(across, -step))
                               .cross(moved(up, step) - moved(up, -step))
                               .normalized();
            if (normal.dot(Vec3d(ellipsoid.positions[v])) < 0) normal = -normal;  // outwards
            EXPECT_LT((Vec3d(ellipsoid.normals[v]) - normal).length(), 1e-5);
        }
        EXPECT_NEAR(volume(ellipsoid) / volume(sphere), std::abs(determinant(shape.row)), 1e-5);
        const Mesh box = shaped_mesh(box_mesh({-1, -0.3f, 0.1f}, {0.4f, 1, 0.7f}), shape);
        for (const auto& [a, b, c] : box.triangles) {
            const Vec3f normal =
                (box.positions[b] - box.positions[a]).cross(box.positions[c] - box.positions[a]).normalized();
            for (const std::uint32_t corner : {a, b, c})
                EXPECT_LT((box.normals[corner] - normal).length(), 1e-5f);
        }
    }
}

}  // namespace
}  // namespace haarfield
