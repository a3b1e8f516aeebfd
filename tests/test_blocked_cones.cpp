#include "shading/walk/blocked_cones.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/wavelets/cubemap.h"
#include "tests/fixtures/cone_oracle.h"
#include "tests/fixtures/example_meshes.h"

namespace haarfield {
namespace {

TEST(BlockedCones, RectanglesBecomeOnePolygonForAnyTriangulation) {
    for (const int cells : {1, 2, 3, 5}) {
        const auto polygons = convex_polygons(make_occluder(square_mesh(2, 0, cells)));
        ASSERT_EQ(polygons.size(), 1u) << cells;
        EXPECT_EQ(polygons[0].corners.size(), 4u);
        EXPECT_TRUE(polygons[0].two_sided);
        EXPECT_NEAR(polygons[0].normal.y, 1, 1e-6);
    }
}

TEST(BlockedCones, BoxesBecomeSixOneSidedPolygons) {
    const auto polygons = convex_polygons(make_occluder(box_mesh({-1, -1, -1}, {1, 2, 3})));
    ASSERT_EQ(polygons.size(), 6u);
    for (const ConvexPolygon& polygon : polygons) {
        EXPECT_EQ(polygon.corners.size(), 4u);
        EXPECT_FALSE(polygon.two_sided);
    }
}

TEST(BlockedCones, NonConvexUnionsAreNotMerged) {
    // An L of three squares.
    Mesh mesh;
    const float corners[][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
    for (const auto& c : corners) {
        mesh.positions.push_back({c[0], 0, c[1]});
        mesh.normals.push_back({0, 1, 0});
    }
    mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {0, 5, 4}};
    mesh.vertex_materials.assign(6, 0);
    mesh.material_names = {""};
    const auto polygons = convex_polygons(make_occluder(mesh));
    EXPECT_GE(polygons.size(), 2u);
    for (const ConvexPolygon& polygon : polygons)
        for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
            const std::size_t n = polygon.corners.size();
            const Vec3f a = polygon.corners[i], b = polygon.corners[(i + 1) % n],
                        c = polygon.corners[(i + 2) % n];
            EXPECT_GT((b - a).cross(c - b).dot(polygon.normal), 0);
        }
}

TEST(BlockedCones, BlockTheSameDirectionsAsTheRasterizer) {
    const Mesh meshes[] = {square_mesh(2, 0, 2), box_mesh({-1, -1, -1}, {1, 2, 3}),
                           box_mesh({-0.2f, 0, -4}, {0.2f, 0.1f, 4})};
    const Vec3f points[] = {
        {0.3f, 0.7f, -0.2f}, {3, 1, 1}, {0.1f, -2, 0.4f}, {-1.5f, 0.5f, 5}, {1.7f, 2.4f, 0.3f}};
    const int size = 32;
    const std::vector<Vec3f> directions = texel_directions(size);
    VisibilityRasterizer rasterizer(size);
    int all_blocked = 0;
    for (const Mesh& mesh : meshes) {
        const Occluder occluder = make_occluder(mesh);
        const auto polygons = convex_polygons(occluder);
        for (const Vec3f& point : points) {
            if (InsideTest(occluder)(point)) continue;
            BlockedConeList cones;
            add_cones(polygons, point, cones);
            const auto open = rasterizer.open_samples(occluder, point);
            for (std::size_t i = 0; i < directions.size(); ++i) {
                if (open[i] != 0 && open[i] != samples_per_texel) continue;
                EXPECT_EQ(is_blocked(cones, directions[i]), open[i] == 0) << point << " " << directions[i];
                all_blocked += open[i] == 0;
            }
        }
    }
    EXPECT_GT(all_blocked, 5000);
}

TEST(BlockedCones, FromThePlaneOfAPolygonNothingIsBlocked) {
    BlockedConeList cones;
    add_cones(convex_polygons(make_occluder(square_mesh(2, 0))), {5, 0, 0}, cones);
    EXPECT_TRUE(cones.end.empty());
}

}  // namespace
}  // namespace haarfield
