#include "shading/function_product.h"

#include <gtest/gtest.h>

#include "fields/haar_transform.h"
#include "tests/pixel_reference.h"

namespace haarfield {
namespace {

using reference::pointers;
using reference::random_trees;
using reference::Texels;

/// Root first, level by level, siblings side by side by quadrant, every node reached once.
template <class Value>
void expect_well_formed(const BasicQuadtree<Value>& tree) {
    std::size_t next = tree.nodes.empty() ? 0 : 1;
    for (const auto& node : tree.nodes) {
        if ((node.children & 15u) == 0) continue;
        EXPECT_EQ(node.children >> 4, next);
        next += std::size_t(std::popcount(node.children & 15u));
    }
    EXPECT_EQ(next, tree.nodes.size());
}

TEST(FunctionProduct, EqualsTexelProductAtAllDepths) {
    for (int levels = 0; levels <= 6; ++levels)
        for (int count = 1; count <= 8; ++count)
            for (const int depth : {0, 1, 2, levels, full_depth}) {
                const int size = 1 << levels;
                const auto trees = random_trees(std::uint32_t(10 * levels + count), count, levels, 0.5);
                std::vector<Texels> factors;
                for (const Quadtree& tree : trees) factors.push_back(reference::texels_of(tree, size, depth));
                const Texels expected = reference::product(factors);
                const Quadtree result = function_product(pointers(trees), depth);
                expect_well_formed(result);
                const Texels texels = reference::texels_of(result, size);
                double largest = 0;
                for (const double value : expected) largest = std::max(largest, std::abs(value));
                for (std::size_t i = 0; i < expected.size(); ++i)
                    ASSERT_NEAR(texels[i], expected[i], 2e-6 * largest)
                        << levels << " levels, " << count << " factors, depth " << depth << ", texel " << i;
                EXPECT_NEAR(result.scaling, reference::mean(expected),
                            1e-6 * reference::absolute_mean(expected));
            }
}

TEST(FunctionProduct, WithLightEqualsTexelProductPerChannel) {
    for (int levels = 0; levels <= 5; ++levels)
        for (int count = 0; count <= 4; ++count)
            for (const int depth : {1, full_depth}) {
                const int size = 1 << levels;
                const RgbQuadtree light = reference::random_rgb_quadtree(std::uint32_t(levels), levels, 0.6);
                const auto trees = random_trees(std::uint32_t(count), count, levels, 0.5);
                const RgbQuadtree result = function_product(light, pointers(trees), depth);
                expect_well_formed(result);
                for (int channel = 0; channel < 3; ++channel) {
                    std::vector<Texels> factors{reference::texels_of(light, channel, size, depth)};
                    for (const Quadtree& tree : trees)
                        factors.push_back(reference::texels_of(tree, size, depth));
                    const Texels expected = reference::product(factors);
                    const Texels texels = reference::texels_of(result, channel, size);
                    double largest = 0;
                    for (const double value : expected) largest = std::max(largest, std::abs(value));
                    for (std::size_t i = 0; i < expected.size(); ++i)
                        ASSERT_NEAR(texels[i], expected[i], 2e-6 * largest) << levels << ", " << count;
                }
            }
}

TEST(FunctionProduct, HasNoNodesWhereAFactorIsZero) {
    // Zero on the left half of the face, so that quadrants 0 and 2 need no nodes.
    const Quadtree half{0.5f, {{{-0.5f, 0, 0}, 0}}};
    const Quadtree other = reference::random_quadtree(3, 5, 1.0);
    const Quadtree* const factors[] = {&half, &other};
    const Quadtree result = function_product(factors);
    ASSERT_FALSE(result.nodes.empty());
    EXPECT_EQ(result.nodes[0].children & 15u, 0b1010u);
    EXPECT_LT(result.nodes.size(), other.nodes.size() * 6 / 10);
}

TEST(InnerProduct, IsThePixelMeanOfTheProduct) {
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
        const Quadtree f = reference::random_quadtree(seed, 6, 0.6);
        const Quadtree g = reference::random_quadtree(100 + seed, 5, 0.6);
        const RgbQuadtree light = reference::random_rgb_quadtree(200 + seed, 6, 0.6);
        const Texels f_texels = reference::texels_of(f, 64), g_texels = reference::texels_of(g, 64);
        const Texels expected = reference::product(std::vector<Texels>{f_texels, g_texels});
        EXPECT_NEAR(inner_product(f, g), reference::mean(expected),
                    1e-6 * reference::absolute_mean(expected));
        EXPECT_EQ(inner_product(f, g), inner_product(g, f));
        const Rgb lit = inner_product(light, g);
        for (int channel = 0; channel < 3; ++channel) {
            const Texels product =
                reference::product(std::vector<Texels>{reference::texels_of(light, channel, 64), g_texels});
            EXPECT_NEAR(lit[channel], reference::mean(product), 1e-6 * reference::absolute_mean(product));
        }
    }
}

TEST(InnerProduct, OfTheProductOfAllButOneIsTheProductIntegral) {
    for (int count = 2; count <= 8; ++count)
        for (std::uint32_t seed = 0; seed < 5; ++seed) {
            const auto trees = random_trees(seed, count, 5, 0.6);
            const auto all = pointers(trees);
            std::vector<Texels> texels;
            for (const Quadtree& tree : trees) texels.push_back(reference::texels_of(tree, 32));
            const double tolerance = 2e-6 * reference::absolute_mean(reference::product(texels));
            for (std::size_t varying = 0; varying < all.size(); ++varying) {
                auto others = all;
                others.erase(others.begin() + std::ptrdiff_t(varying));
                const Quadtree transfer = function_product(others);
                EXPECT_NEAR(inner_product(transfer, *all[varying]), product_integral(all), tolerance)
                    << count << " factors, all but " << varying;
            }
        }
}

}  // namespace
}  // namespace haarfield
