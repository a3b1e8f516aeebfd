#include "fields/quadtree_pool.h"

#include <gtest/gtest.h>

#include <random>

#include "fields/haar_transform.h"

namespace haarfield {
namespace {

CubemapTree random_cubemap(std::uint32_t seed, int size, int coefficients) {
    std::mt19937 random(seed);
    std::vector<float> texels(static_cast<std::size_t>(6 * size * size));
    for (float& t : texels) t = static_cast<float>(random() % 9) / 8;
    return haar_cubemap<float>(texels, size, {coefficients});
}

TEST(QuadtreePool, GivesBackTreesToHalfPrecision) {
    QuadtreePoolBuilder builder(16);
    std::vector<CubemapTree> trees;
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        trees.push_back(random_cubemap(seed, 16, 40));
        EXPECT_EQ(builder.add(trees.back()), static_cast<std::int32_t>(seed));
    }
    const QuadtreePool pool = std::move(builder).finish();
    EXPECT_EQ(pool_defect(pool), "");
    for (std::size_t i = 0; i < trees.size(); ++i)
        for (std::size_t face = 0; face < 6; ++face) {
            const Quadtree tree = unpacked_face(pool, pool.cubemaps[i][face]);
            const std::vector<float> wanted = quadtree_texels(trees[i].faces[face], 16),
                                     found = quadtree_texels(tree, 16);
            for (std::size_t t = 0; t < wanted.size(); ++t) EXPECT_NEAR(found[t], wanted[t], 2e-3);
            ASSERT_EQ(tree.nodes.size(), trees[i].faces[face].nodes.size());
            for (std::size_t n = 0; n < tree.nodes.size(); ++n)
                EXPECT_EQ(tree.nodes[n].children, trees[i].faces[face].nodes[n].children);
        }
}

TEST(QuadtreePool, StoresEqualCubemapsAndFacesOnce) {
    QuadtreePoolBuilder builder(16);
    CubemapTree a = random_cubemap(1, 16, 0), b = a;
    EXPECT_EQ(builder.add(a), 0);
    EXPECT_EQ(builder.add(b), 0);
    b.faces[3].scaling = 0.25f;
    EXPECT_EQ(builder.add(b), 1);
    CubemapTree open;
    for (Quadtree& face : open.faces) face.scaling = 1;
    EXPECT_EQ(builder.add(open), 2);
    const QuadtreePool pool = std::move(builder).finish();
    EXPECT_EQ(pool.cubemaps.size(), 3u);
    EXPECT_EQ(pool.faces.size(), 8u);  // six of a, one of b, and one for all of `open`
}

TEST(QuadtreePool, DefectsAreFound) {
    QuadtreePoolBuilder builder(16);
    builder.add(random_cubemap(3, 16, 30));
    const QuadtreePool pool = std::move(builder).finish();
    const auto defect_after = [&](auto change) {
        QuadtreePool changed = pool;
        change(changed);
        return pool_defect(changed);
    };
    EXPECT_NE(defect_after([](QuadtreePool& p) { p.face_size = 48; }), "");
    EXPECT_NE(defect_after([](QuadtreePool& p) { p.face_size = 2; }), "");
    const auto change = [](auto& table, auto edit) {
        std::vector values(table.begin(), table.end());
        edit(values);
        table = std::move(values);
    };
    const auto defect_of_cubemaps = [&](auto edit) {
        return defect_after([&](QuadtreePool& p) { change(p.cubemaps, edit); });
    };
    const auto defect_of_faces = [&](auto edit) {
        return defect_after([&](QuadtreePool& p) { change(p.faces, edit); });
    };
    const auto defect_of_nodes = [&](auto edit) {
        return defect_after([&](QuadtreePool& p) { change(p.nodes, edit); });
    };
    EXPECT_EQ(defect_of_nodes([](auto&) {}), "");
    EXPECT_NE(defect_of_cubemaps([](auto& cubemaps) { cubemaps[0][2] = 6; }), "");
    EXPECT_NE(defect_of_faces([](auto& faces) { faces[1].first_node = 0xffffffff; }), "");
    EXPECT_NE(defect_of_faces([](auto& faces) { --faces[0].node_count; }), "");
    EXPECT_NE(defect_of_nodes([](auto& nodes) { nodes[0].children ^= 16; }), "");
    EXPECT_NE(defect_of_nodes([](auto& nodes) { nodes[1].wavelet[1] = 0x7c00; }), "");
    EXPECT_NE(defect_of_faces([](auto& faces) { faces[2].scaling = 0x7e00; }), "");
    EXPECT_NE(defect_of_nodes([](auto& nodes) { nodes.pop_back(); }), "");
}

}  // namespace
}  // namespace haarfield
