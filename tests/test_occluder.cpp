#include "fields/mesh/occluder.h"

#include <gtest/gtest.h>

#include "tests/fixtures/example_meshes.h"

namespace haarfield {
namespace {

TEST(Occluder, ClosedOutwardPiecesAreOneSidedAndAllOthersTwoSided) {
    const Mesh box = box_mesh({-1, 0, -1}, {1, 2, 1}), square = square_mesh(4, 0);
    EXPECT_EQ(make_occluder(box).one_sided, 12u);
    EXPECT_EQ(make_occluder(square).one_sided, 0u);
    const Occluder both = make_occluder(joined_meshes(square, box));
    EXPECT_EQ(both.one_sided, 12u);
    EXPECT_EQ(both.triangles.size(), 14u);
    Mesh inside_out = box;
    for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
    EXPECT_EQ(make_occluder(inside_out).one_sided, 0u);
    Mesh one_flipped = box;
    std::swap(one_flipped.triangles[5][0], one_flipped.triangles[5][1]);
    EXPECT_EQ(make_occluder(one_flipped).one_sided, 0u);
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
        if (!in_box && r > 0.69f && r < 0.701f) continue;  // between the facets and the true sphere
        EXPECT_EQ(is_inside(p), in_box || r < 0.695f) << p;
        inside += is_inside(p);
    }
    EXPECT_GT(inside, 500);
}

}  // namespace
}  // namespace haarfield
