#include "fields/occluder/occluder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fixtures/example_meshes.h"

namespace haarfield {
namespace {

TEST(Occluder, ClosedOutwardPiecesAreOneSidedAndAllOthersTwoSided) {
    const Mesh box = box_mesh({-1, 0, -1}, {1, 2, 1}), square = square_mesh(4, 0);
    EXPECT_EQ(make_occluder(box).one_sided(), 12u);
    EXPECT_EQ(make_occluder(square).one_sided(), 0u);
    const Occluder both = make_occluder(joined_meshes(square, box));
    EXPECT_EQ(both.one_sided(), 12u);
    EXPECT_EQ(both.triangles().size(), 14u);
    Mesh inside_out = box;
    for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
    EXPECT_EQ(make_occluder(inside_out).one_sided(), 0u);
    Mesh one_flipped = box;
    std::swap(one_flipped.triangles[5][0], one_flipped.triangles[5][1]);
    EXPECT_EQ(make_occluder(one_flipped).one_sided(), 0u);
}

TEST(Occluder, DerivedDataFollowTheTriangles) {
    Occluder occluder = make_occluder(box_mesh({-1, 0, -1}, {1, 2, 1}));
    ASSERT_GT(occluder.edges().one_sided_clusters, 0u);
    OccluderTriangles changed = occluder.source();
    changed.positions[0] += Vec3f(0.5f, 0, 0);
    changed.triangles.pop_back();
    changed.one_sided = 0;
    occluder = Occluder(changed);
    EXPECT_EQ(occluder.edges().one_sided_clusters, 0u);
    EXPECT_EQ(occluder.padded_positions()[0], changed.positions[0].x);
    EXPECT_TRUE(std::isnan(occluder.planes().offset[changed.triangles.size()]));
    for (const AxisGrid& grid : occluder.grids())
        grid.visit_triangles_at(
            0, 0, [&](std::uint32_t triangle) { EXPECT_LT(triangle, changed.triangles.size()); });
}

TEST(InsideTest, KnowsTheInsideOfPenetratingClosedPieces) {
    const Mesh mesh =
        joined_meshes(joined_meshes(box_mesh({-1, 0, -1}, {1, 2, 1}), sphere_mesh({1, 1, 0}, 0.7f, 24)),
                      square_mesh(8, -1));
    const Occluder occluder = make_occluder(mesh);
    const InsideTest is_inside(occluder);
    std::uint32_t seed = 7;
    const auto uniform = [&] {
        seed = seed * 1664525u + 1013904223u;
        return static_cast<float>(seed >> 8) / static_cast<float>(1u << 24) * 4 - 2;
    };
    int inside = 0;
    for (int i = 0; i < 5000; ++i) {
        const Vec3f p(uniform(), uniform() + 1, uniform());
        const bool in_box = std::abs(p.x) < 1 && p.y > 0 && p.y < 2 && std::abs(p.z) < 1;
        const float r = (p - Vec3f(1, 1, 0)).length();
        if (!in_box && r > 0.69f && r < 0.701f) continue;  // between the facets and the exact sphere
        EXPECT_EQ(is_inside(p), in_box || r < 0.695f) << p;
        inside += is_inside(p);
    }
    EXPECT_GT(inside, 500);
}

}  // namespace
}  // namespace haarfield
