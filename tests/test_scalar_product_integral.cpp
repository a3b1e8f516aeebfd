#include "tests/baselines/scalar_product_integral.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fields/wavelets/haar_transform.h"
#include "tests/baselines/general_basis.h"
#include "tests/baselines/paper_product_integral.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

using reference::PaperCumulation;
using reference::PaperFold;
using reference::pointers;
using reference::random_trees;
using reference::Texels;

/// Returns factors similar to visibility: half planes. Products of many of them nearly vanish.
std::vector<Quadtree> half_plane_trees(std::uint32_t seed, int count, int size, int coefficients) {
    std::vector<Quadtree> trees;
    for (int i = 0; i < count; ++i) {
        const auto texels = reference::half_plane_texels(100 * seed + std::uint32_t(i), size);
        trees.push_back(haar_quadtree<float>(texels, size, {coefficients, 0.0f}));
    }
    return trees;
}

/// The scale of errors: the mean of the product's absolute value, which is stricter than the header's
/// promise, or the promised product of the factors' L2 norms if the product nearly vanishes.
enum class Scale { product, norms };

void expect_pixel_sum(const std::vector<Quadtree>& trees, int size, int depth, Scale scale) {
    std::vector<Texels> texels;
    double norms = 1;
    for (const Quadtree& tree : trees) {
        texels.push_back(reference::texels_of(tree, size, depth));
        const Texels square = reference::product(std::vector<Texels>{texels.back(), texels.back()});
        norms *= std::sqrt(reference::mean(square));
    }
    const Texels product = reference::product(texels);
    EXPECT_NEAR(reference::scalar_product_integral(pointers(trees), depth), reference::mean(product),
                1e-6 * (scale == Scale::norms ? norms : reference::absolute_mean(product)))
        << trees.size() << " factors, size " << size << ", depth " << depth;
}

TEST(ScalarProductIntegral, EqualsPixelSumForOneToEightFactorsAtAllDepths) {
    for (int levels = 0; levels <= 7; ++levels)
        for (int count = 1; count <= 8; ++count)
            for (const double density : {0.3, 0.6, 1.0}) {
                if (density == 1.0 && levels > 5) continue;
                const auto trees = random_trees(std::uint32_t(levels * 10 + count), count, levels, density);
                for (int depth = 0; depth <= levels; ++depth)
                    expect_pixel_sum(trees, 1 << levels, depth, Scale::product);
                expect_pixel_sum(trees, 1 << levels, full_depth, Scale::product);
            }
}

TEST(ScalarProductIntegral, EqualsPixelSumForHalfPlanes) {
    for (const int coefficients : {0, 70})
        for (int count = 2; count <= 8; ++count)
            for (std::uint32_t seed = 0; seed < 5; ++seed)
                for (const int depth : {2, 4, full_depth})
                    expect_pixel_sum(half_plane_trees(seed, count, 64, coefficients), 64, depth,
                                     Scale::norms);
}

TEST(ScalarProductIntegral, IsExactOnTheLargestFace) {
    expect_pixel_sum(random_trees(1, 4, 8, 0.7), 256, full_depth, Scale::product);
}

TEST(ScalarProductIntegral, TreatsNodesAtLevelDepthAsAbsent) {
    // One wavelet per level on the upper left square: each depth adds exactly one to the square of f.
    Quadtree tree;
    tree.scaling = 1;
    for (std::uint32_t level = 0; level < 3; ++level)
        tree.nodes.push_back({{0.5f, 0, 0}, level < 2 ? (level + 1) << 4 | 1u : 0u});
    const std::vector<const Quadtree*> factors{&tree, &tree};
    const double expected[] = {1, 1 + 0.25, 1 + 0.25 + 0.25 / 4, 1 + 0.25 + 0.25 / 4 + 0.25 / 16};
    for (int depth = 0; depth <= 3; ++depth)
        EXPECT_FLOAT_EQ(reference::scalar_product_integral(factors, depth), float(expected[depth])) << depth;
    EXPECT_FLOAT_EQ(reference::scalar_product_integral(factors), float(expected[3]));
}

TEST(ScalarProductIntegral, OfOneFactorIsItsMean) {
    const auto trees = random_trees(7, 1, 5, 0.5);
    EXPECT_EQ(reference::scalar_product_integral(pointers(trees)), trees[0].scaling);
}

TEST(ScalarProductIntegral, VanishesWithAnyFactorThatIsZero) {
    auto trees = random_trees(8, 5, 5, 0.5);
    trees[3] = Quadtree{};
    EXPECT_EQ(reference::scalar_product_integral(pointers(trees)), 0.0f);
}

TEST(ScalarProductIntegral, TakesSixtyFourFactors) {
    std::vector<Quadtree> trees;
    for (std::uint32_t i = 0; i < 64; ++i) {
        std::vector<float> texels = reference::noise_texels(i, 64);
        for (float& texel : texels) texel = 0.95f + 0.1f * texel;
        trees.push_back(haar_quadtree<float>(texels, 8));
    }
    std::vector<Texels> texels;
    for (const Quadtree& tree : trees) texels.push_back(reference::texels_of(tree, 8));
    const double expected = reference::mean(reference::product(texels));
    EXPECT_NEAR(reference::scalar_product_integral(pointers(trees)), expected, 5e-6 * expected);
}

TEST(ScalarProductIntegral, OfLightEqualsPixelSumPerChannelInOneWalk) {
    for (int levels = 0; levels <= 6; ++levels)
        for (int count = 0; count <= 6; ++count)
            for (const int depth : {0, 1, 3, full_depth}) {
                const RgbQuadtree light = reference::random_rgb_quadtree(std::uint32_t(levels), levels, 0.6);
                const auto trees = random_trees(std::uint32_t(50 + count), count, levels, 0.5);
                const Rgb result = reference::scalar_product_integral(light, pointers(trees), depth);
                for (int channel = 0; channel < 3; ++channel) {
                    std::vector<Texels> texels{reference::texels_of(light, channel, 1 << levels, depth)};
                    for (const Quadtree& tree : trees)
                        texels.push_back(reference::texels_of(tree, 1 << levels, depth));
                    const Texels product = reference::product(texels);
                    EXPECT_NEAR(result[channel], reference::mean(product),
                                1e-6 * reference::absolute_mean(product))
                        << levels << " levels, " << count << " factors, depth " << depth << ", channel "
                        << channel;
                }
            }
}

TEST(ScalarProductIntegral, OverTheCubemapIsTheSumOverItsFaces) {
    RgbCubemapTree light;
    CubemapTree visibility, lobe;
    Vec3d expected(0, 0, 0);
    for (std::uint32_t face = 0; face < cubemap_faces; ++face) {
        light.faces[face] = reference::random_rgb_quadtree(face, 4, 0.7);
        visibility.faces[face] = reference::random_quadtree(10 + face, 4, 0.7);
        lobe.faces[face] = reference::random_quadtree(20 + face, 4, 0.7);
        for (int channel = 0; channel < 3; ++channel) {
            const std::vector<Texels> texels{reference::texels_of(light.faces[face], channel, 16),
                                             reference::texels_of(visibility.faces[face], 16),
                                             reference::texels_of(lobe.faces[face], 16)};
            expected[channel] += reference::mean(reference::product(texels));
        }
    }
    const CubemapTree* const factors[] = {&visibility, &lobe};
    const Rgb result = reference::scalar_product_integral(light, factors);
    for (int channel = 0; channel < 3; ++channel)
        EXPECT_NEAR(result[channel], expected[channel], 1e-5) << channel;
}

TEST(ScalarProductIntegral, EqualsThePapersAlgorithmCorrected) {
    for (int count = 2; count <= 8; ++count)
        for (std::uint32_t seed = 0; seed < 10; ++seed) {
            const auto trees = random_trees(seed, count, 5, 0.6);
            const double table = reference::paper_product_integral(pointers(trees));
            EXPECT_NEAR(reference::scalar_product_integral(pointers(trees)), table,
                        2e-6 * std::max(1.0, std::abs(table)))
                << count << " factors, seed " << seed;
            if (count > 6) continue;
            const double recursion =
                reference::paper_product_integral(pointers(trees), {PaperFold::recursion});
            EXPECT_NEAR(recursion, table, 1e-12 * std::max(1.0, std::abs(table)));
        }
}

TEST(ScalarProductIntegral, AsPrintedForgetsTreesThatEndedAbove) {
    // f ends on the root. g and h continue for two levels, on which f's mean of a quadrant must stay a
    // factor.
    Quadtree f{2.0f, {{{0.5f, 0, 0}, 0}}};
    Quadtree g{1.0f, {{{0, 0, 0}, 1 << 4 | 1}, {{0, 0, 0}, 2 << 4 | 1}, {{1.0f, 0, 0}, 0}}};
    const std::vector<const Quadtree*> factors{&f, &g, &g};
    const double corrected = reference::paper_product_integral(factors);
    const double printed =
        reference::paper_product_integral(factors, {PaperFold::table, PaperCumulation::as_printed});
    EXPECT_NEAR(reference::scalar_product_integral(factors), 2 + 2.5 / 16, 1e-6);
    EXPECT_NEAR(corrected, 2 + 2.5 / 16, 1e-12);
    EXPECT_NEAR(printed, 2 + 1.0 / 16, 1e-12);
}

TEST(ScalarProductIntegral, EqualsTheSumOverCoefficientsOnSmallTrees) {
    for (std::uint32_t seed = 0; seed < 8; ++seed)
        for (int count = 2; count <= 4; ++count) {
            const int levels = count == 4 ? 2 : 3;
            const auto trees = random_trees(seed, count, levels, 0.7);
            const double sum = baseline::general_basis_integral(pointers(trees), levels);
            EXPECT_NEAR(reference::scalar_product_integral(pointers(trees)), sum,
                        1e-6 * std::max(1.0, std::abs(sum)))
                << count << " factors, seed " << seed;
        }
}

}  // namespace
}  // namespace haarfield
