#include "fields/wavelets/quadtree_pool.h"

#include <gtest/gtest.h>

#include <random>

#include "fields/wavelets/haar_transform.h"

#include "tests/fixtures/unpacked_face.h"

namespace haarfield {
namespace {

/// Returns a cubemap of multiples of 1/8, many of them equal.
CubemapTree random_cubemap(std::uint32_t seed, int size, int coefficients) {
    std::mt19937 random(seed);
    std::vector<float> texels(static_cast<std::size_t>(6 * size * size));
    for (float& t : texels) t = static_cast<float>(random() % 9) / 8;
    return haar_cubemap<float>(texels, size, {coefficients});
}

PackedTrees packed(const CubemapTree& tree) {
    PackedTrees trees;
    pack_trees(tree, trees);
    return trees;
}

QuadtreePool pool_of(const std::vector<CubemapTree>& trees, int size) {
    QuadtreePoolBuilder builder(size);
    for (const CubemapTree& tree : trees) builder.add(packed(tree));
    return std::move(builder).finish();
}

TEST(QuadtreePool, RestoresTreesWithinHalfAStep) {
    std::vector<CubemapTree> trees;
    for (std::uint32_t seed = 0; seed < 20; ++seed) trees.push_back(random_cubemap(seed, 16, 40));
    const QuadtreePool pool = pool_of(trees, 16);
    EXPECT_EQ(pool_defect(pool), "");
    std::size_t nodes = 0;
    for (std::size_t i = 0; i < trees.size(); ++i)
        for (std::size_t face = 0; face < 6; ++face) {
            const Quadtree tree = unpacked_face(pool, pool.cubemaps[i][face]), &wanted = trees[i].faces[face];
            EXPECT_NEAR(tree.scaling, wanted.scaling, 3e-4);
            ASSERT_EQ(tree.nodes.size(), wanted.nodes.size());
            nodes += tree.nodes.size();
            for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
                EXPECT_EQ(tree.nodes[n].children, wanted.nodes[n].children);
                for (std::size_t kind = 0; kind < 3; ++kind)
                    EXPECT_NEAR(tree.nodes[n].wavelet[kind], wanted.nodes[n].wavelet[kind],
                                0.5f * wavelet_step * 1.0001f);
            }
        }
    EXPECT_EQ(node_count(pool), nodes);
}

TEST(QuadtreePool, PackingReplacesEarlierContent) {
    PackedTrees once, twice;
    const CubemapTree tree = random_cubemap(5, 16, 20);
    pack_trees(tree, once);
    pack_trees(random_cubemap(6, 16, 40), twice);
    pack_trees(tree, twice);
    EXPECT_EQ(twice.faces, once.faces);
    EXPECT_EQ(twice.node_bytes, once.node_bytes);
}

TEST(QuadtreePool, HoldsHalfOpenSquaresExactly) {
    CubemapTree tree;
    tree.faces[2].scaling = 0.5f;
    tree.faces[2].nodes = {{{-0.5f, 0, 0}, 0}};
    tree.faces[3].scaling = 0.5f;
    tree.faces[3].nodes = {{{0, 0, 0.5f}, 0}};
    const QuadtreePool pool = pool_of({tree}, 16);
    EXPECT_EQ(unpacked_face(pool, pool.cubemaps[0][2]).nodes[0].wavelet[0], -0.5f);
    EXPECT_EQ(unpacked_face(pool, pool.cubemaps[0][3]).nodes[0].wavelet[2], 0.5f);
}

TEST(QuadtreePool, LeavesOutWhatRoundsToZero) {
    CubemapTree tree;
    Quadtree& face = tree.faces[4];
    const float small = 0.4f * wavelet_step;
    // A root with three children: one is too small, one only leads to a wavelet, one leads to none.
    face.nodes = {
        {{0.25f, 0, 0}, 1u << 4 | 0b1011u}, {{small, small, -small}, 0}, {{0, small, 0}, 4u << 4 | 0b0100u},
        {{0, 0, small}, 5u << 4 | 0b0001u}, {{0, 0.125f, 0}, 0},         {{small, 0, 0}, 0}};
    const QuadtreePool pool = pool_of({tree}, 16);
    EXPECT_EQ(pool_defect(pool), "");
    const Quadtree found = unpacked_face(pool, pool.cubemaps[0][4]);
    ASSERT_EQ(found.nodes.size(), 3u);
    EXPECT_EQ(found.nodes[0].children, 1u << 4 | 0b0010u);
    EXPECT_EQ(found.nodes[1].children, 2u << 4 | 0b0100u);
    EXPECT_EQ(found.nodes[1].wavelet, (std::array<float, 3>{0, 0, 0}));
    EXPECT_NEAR(found.nodes[2].wavelet[1], 0.125f, wavelet_step);
}

TEST(QuadtreePool, StoresEqualCubemapsAndFacesOnce) {
    QuadtreePoolBuilder builder(16);
    CubemapTree a = random_cubemap(1, 16, 0), b = a;
    EXPECT_EQ(builder.add(packed(a)), 0);
    EXPECT_EQ(builder.add(packed(b)), 0);
    b.faces[3].scaling = 0.25f;
    EXPECT_EQ(builder.add(packed(b)), 1);
    CubemapTree open;
    for (Quadtree& face : open.faces) face.scaling = 1;
    EXPECT_EQ(builder.add(packed(open)), 2);
    EXPECT_EQ(builder.add(packed(a)), 0);
    const QuadtreePool pool = std::move(builder).finish();
    EXPECT_EQ(pool.cubemaps.size(), 3u);
    EXPECT_EQ(pool.faces.size(), 8u);  // six of a, one of b, and one for all of `open`
}

TEST(QuadtreePool, DefectsAreFound) {
    const CubemapTree tree = random_cubemap(3, 16, 30);
    const QuadtreePool pool = pool_of({tree}, 16);
    ASSERT_EQ(pool_defect(pool), "");
    struct Parts {
        int face_size;
        std::vector<std::uint8_t> node_bytes;
        std::vector<PackedFace> faces;
        std::vector<PackedCubemap> cubemaps;
    };
    const auto defect_after = [&](auto change) {
        Parts parts{pool.face_size,
                    {pool.node_bytes.begin(), pool.node_bytes.end()},
                    {pool.faces.begin(), pool.faces.end()},
                    {pool.cubemaps.begin(), pool.cubemaps.end()}};
        change(parts);
        return pool_defect({parts.face_size, parts.node_bytes, parts.faces, parts.cubemaps});
    };
    EXPECT_EQ(defect_after([](Parts&) {}), "");
    EXPECT_NE(defect_after([](Parts& p) { p.face_size = 48; }), "");
    EXPECT_NE(defect_after([](Parts& p) { p.face_size = 2; }), "");
    EXPECT_NE(defect_after([](Parts& p) { p.cubemaps[0][2] = 6; }), "");
    EXPECT_NE(defect_after([](Parts& p) { p.faces[1].set_first_byte(0xffffffff); }), "");
    EXPECT_NE(defect_after([](Parts& p) { --p.faces[0].node_count; }), "");
    EXPECT_NE(defect_after([](Parts& p) { ++p.faces[0].node_count; }), "");
    EXPECT_NE(defect_after([](Parts& p) { p.node_bytes[0] ^= 1; }), "");    // one child more or fewer
    EXPECT_NE(defect_after([](Parts& p) { p.node_bytes[0] |= 128; }), "");  // an unused bit
    EXPECT_NE(defect_after([](Parts& p) { p.faces[2].scaling = 0x7e00; }), "");
    EXPECT_NE(defect_after([](Parts& p) { p.node_bytes.pop_back(); }), "");
}

}  // namespace
}  // namespace haarfield
