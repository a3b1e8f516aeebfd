#include "shading/walk/product_integral.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <memory>
#include <random>

#include "fields/wavelets/haar_transform.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

using reference::Texels;

/// Factors that are weighted sums of random trees, and their texels, by face.
struct ExampleFactors {
    int size;
    std::vector<std::unique_ptr<WideCubemapTree>> trees;
    std::vector<std::vector<WeightedTrees<float>::Part>> parts;
    std::vector<WeightedTrees<float>> factors;
    std::array<std::vector<Texels>, cubemap_faces> texels;

    /// Factor i has i % 3 + 1 trees, some of them constant on some faces.
    ExampleFactors(std::uint32_t seed, int count, int levels, double density, int depth = full_depth)
        : size(1 << levels) {
        parts.resize(std::size_t(count));
        for (int i = 0; i < count; ++i) {
            std::array<Texels, cubemap_faces> sum;
            const float constant = i % 2 ? 0.3f : 0.0f;
            sum.fill(Texels(std::size_t(size) * std::size_t(size), constant));
            for (int k = 0; k <= i % 3; ++k) {
                CubemapTree tree;
                const float weight = k == 0 ? 1.0f : 0.25f * float(k);
                for (std::uint32_t face = 0; face < cubemap_faces; ++face) {
                    const int deep = (face + std::uint32_t(i + k)) % 4 == 0 ? 0 : levels;
                    tree.faces[face] = reference::random_quadtree(
                        1000 * seed + 60 * std::uint32_t(i) + 10 * std::uint32_t(k) + face, deep, density);
                    const Texels part = reference::texels_of(tree.faces[face], size, depth);
                    for (std::size_t t = 0; t < part.size(); ++t) sum[face][t] += double(weight) * part[t];
                }
                trees.push_back(std::make_unique<WideCubemapTree>(tree));
                parts[std::size_t(i)].push_back({&trees.back()->faces(), weight});
            }
            factors.push_back({constant, parts[std::size_t(i)]});
            for (std::size_t face = 0; face < cubemap_faces; ++face) texels[face].push_back(sum[face]);
        }
    }
};

RgbCubemapTree random_light(std::uint32_t seed, int levels, double density) {
    RgbCubemapTree light;
    for (std::uint32_t face = 0; face < cubemap_faces; ++face)
        light.faces[face] = reference::random_rgb_quadtree(seed + face, face == 4 ? 0 : levels, density);
    return light;
}

/// The sum, and the sum of magnitudes, over the faces.
struct Expected {
    double value = 0, magnitude = 0;
};

Expected expected_integral(const RgbCubemapTree& light, const ExampleFactors& example, int channel,
                           int depth) {
    Expected sum;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        std::vector<Texels> all = example.texels[face];
        all.push_back(reference::texels_of(light.faces[face], channel, example.size, depth));
        const Texels product = reference::product(all);
        sum.value += reference::mean(product);
        sum.magnitude += reference::absolute_mean(product);
    }
    return sum;
}

TEST(ProductIntegrals, AreBitIdenticalToEachOneAlone) {
    const LightPyramid light(random_light(3, 5, 0.6), 32);
    WalkMemory<float> memory;
    std::vector<ExampleFactors> examples;
    for (std::uint32_t i = 0; i < 19; ++i) examples.emplace_back(i, int(i % 4), 5, 0.5);
    std::vector<std::span<const WeightedTrees<float>>> factors;
    for (const ExampleFactors& example : examples) factors.push_back(example.factors);
    for (const int depth : {full_depth, 3}) {
        std::vector<Rgb> found(factors.size(), Rgb(-1.0f));
        product_integrals(light, factors, depth, memory, found);
        for (std::size_t i = 0; i < factors.size(); ++i)
            EXPECT_EQ(found[i], product_integral(light, factors[i], depth, memory)) << i;
    }
    product_integrals(light, {}, full_depth, memory, {});
}

TEST(ProductIntegral, EqualsPixelSumAtAllDepths) {
    WalkMemory<float> memory;
    for (int levels = 0; levels <= 7; ++levels)
        for (int count = 0; count <= 6; ++count)
            for (int depth = 0; depth <= levels + 1; ++depth) {
                const auto seed = std::uint32_t(levels * 10 + count);
                const RgbCubemapTree light = random_light(seed, levels, 0.6);
                const ExampleFactors example(seed, count, levels, levels > 5 ? 0.5 : 0.7, depth);
                const Rgb found =
                    product_integral(LightPyramid(light, example.size), example.factors, depth, memory);
                for (int channel = 0; channel < 3; ++channel) {
                    const Expected wanted = expected_integral(light, example, channel, depth);
                    EXPECT_NEAR(found[channel], wanted.value, 1e-6 * wanted.magnitude)
                        << levels << " levels, " << count << " factors, depth " << depth << ", channel "
                        << channel;
                }
            }
}

TEST(ProductIntegral, WithoutLightEqualsPixelSumAtAllDepths) {
    WalkMemory<float> memory;
    for (int levels = 0; levels <= 6; ++levels)
        for (int count = 0; count <= 6; ++count)
            for (int depth = 0; depth <= levels + 1; ++depth) {
                const ExampleFactors example(std::uint32_t(levels * 10 + count), count, levels, 0.6, depth);
                Expected wanted;
                for (std::size_t face = 0; face < cubemap_faces; ++face) {
                    const Texels product =
                        count == 0 ? Texels(std::size_t(example.size) * std::size_t(example.size), 1.0)
                                   : reference::product(example.texels[face]);
                    wanted.value += reference::mean(product);
                    wanted.magnitude += reference::absolute_mean(product);
                }
                EXPECT_NEAR(product_integral(example.size, example.factors, depth, memory), wanted.value,
                            1e-6 * wanted.magnitude)
                    << levels << " levels, " << count << " factors, depth " << depth;
            }
}

TEST(ProductIntegral, TakesATreeAsAFactorWhereverItIsMoved) {
    std::vector<WideCubemapTree> trees;
    std::vector<WeightedTrees<float>> factors;
    std::vector<CubemapTree> functions(3);
    for (std::uint32_t i = 0; i < functions.size(); ++i) {
        for (std::uint32_t face = 0; face < cubemap_faces; ++face)
            functions[i].faces[face] = reference::random_quadtree(10 * i + face, 4, 0.7);
        trees.emplace_back(functions[i]);  // moves the earlier ones
        factors.push_back(trees.back().factor());
    }
    Expected wanted;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        std::vector<Texels> texels;
        for (const CubemapTree& f : functions) texels.push_back(reference::texels_of(f.faces[face], 16));
        wanted.value += reference::mean(reference::product(texels));
        wanted.magnitude += reference::absolute_mean(reference::product(texels));
    }
    WalkMemory<float> memory;
    EXPECT_NEAR(product_integral(16, factors, full_depth, memory), wanted.value, 1e-6 * wanted.magnitude);
}

TEST(ProductIntegral, IsExactOnTheLargestFace) {
    WalkMemory<float> memory;
    const RgbCubemapTree light = random_light(1, 8, 0.6);
    const ExampleFactors example(2, 3, 8, 0.6);
    const Rgb found = product_integral(LightPyramid(light, 256), example.factors, full_depth, memory);
    const Expected wanted = expected_integral(light, example, 1, full_depth);
    EXPECT_NEAR(found[1], wanted.value, 1e-6 * wanted.magnitude);
}

TEST(ProductIntegral, VanishesWithAnyFactorThatIsZero) {
    WalkMemory<float> memory;
    ExampleFactors example(3, 4, 4, 0.7);
    example.factors.push_back({0, {}});
    EXPECT_EQ(
        product_integral(LightPyramid(random_light(3, 4, 0.7), 16), example.factors, full_depth, memory),
        Rgb(0.0f));
}

TEST(ProductIntegral, OfHalfSpacesIsZeroWhereTheyExcludeEachOther) {
    // Visibilities of two disjoint half planes: exactly zero, without a traversal down to the texels.
    std::vector<float> left(64 * 64), right(64 * 64);
    for (std::size_t i = 0; i < left.size(); ++i) {
        left[i] = i % 64 < 29 ? 1.0f : 0.0f;
        right[i] = 1 - left[i];
    }
    CubemapTree left_tree, right_tree;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        left_tree.faces[face] = haar_quadtree<float>(left, 64);
        right_tree.faces[face] = haar_quadtree<float>(right, 64);
    }
    const WideCubemapTree a(left_tree), b(right_tree);
    const std::array factors{a.factor(), b.factor()};
    WalkMemory<float> memory;
    EXPECT_EQ(product_integral(LightPyramid(random_light(3, 6, 0.7), 64), factors, full_depth, memory),
              Rgb(0.0f));
}

/// Returns the texels of a channel, by face.
std::array<Texels, cubemap_faces> texels_of(const CubemapTree& tree, int, int size) {
    std::array<Texels, cubemap_faces> result;
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        result[face] = reference::texels_of(tree.faces[face], size);
    return result;
}

std::array<Texels, cubemap_faces> texels_of(const RgbCubemapTree& tree, int channel, int size) {
    std::array<Texels, cubemap_faces> result;
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        result[face] = reference::texels_of(tree.faces[face], channel, size);
    return result;
}

/// Returns the texels that wavelet blocks represent, by face.
template <int channels>
std::array<Texels, cubemap_faces> texels_of(const std::vector<WaveletBlock<channels>>& blocks, int channel,
                                            int size) {
    std::array<Texels, cubemap_faces> result;
    result.fill(Texels(std::size_t(size) * std::size_t(size)));
    struct Square {
        std::size_t face;
        int x, y, side;
    };
    std::vector<Square> squares;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        const auto& block = blocks[i];
        Square square{block.block, 0, 0, size};
        const auto child = [](const Square& s, std::uint32_t quadrant) {
            return Square{s.face, s.x + int(quadrant % 2) * s.side / 2, s.y + int(quadrant / 2) * s.side / 2,
                          s.side / 2};
        };
        if (block.parent != i) {
            EXPECT_LT(block.parent, i);
            square = child(child(squares[block.parent], block.cell / 4), block.cell % 4);
        }
        squares.push_back(square);
        const auto add = [&](const Square& s, double mean, double x, double y, double diagonal) {
            for (int row = 0; row < s.side; ++row)
                for (int column = 0; column < s.side; ++column) {
                    const double sx = 2 * column < s.side ? 1 : -1, sy = 2 * row < s.side ? 1 : -1;
                    result[s.face][std::size_t((s.y + row) * size + s.x + column)] +=
                        mean + sx * x + sy * y + sx * sy * diagonal;
                }
        };
        const auto& a = block.amplitude[std::size_t(channel)];
        add(square, block.parent == i ? a[0] : 0, a[4], a[8], a[12]);
        for (std::uint32_t q = 0; q < 4; ++q)
            add(child(square, q), 0, a[4 * q + 1], a[4 * q + 2], a[4 * q + 3]);
    }
    return result;
}

void expect_texels(const std::array<Texels, cubemap_faces>& found,
                   const std::array<Texels, cubemap_faces>& wanted) {
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        double largest = 0;
        for (const double value : wanted[face]) largest = std::max(largest, std::abs(value));
        for (std::size_t i = 0; i < wanted[face].size(); ++i)
            ASSERT_NEAR(found[face][i], wanted[face][i], 2e-6 * largest)
                << "face " << face << ", texel " << i;
    }
}

TEST(FunctionProduct, EqualsTexelProduct) {
    WalkMemory<float> memory;
    std::vector<WaveletBlock<1>> blocks;
    for (const int levels : {1, 3, 4, 6})
        for (int count = 1; count <= 5; ++count)
            for (const int depth : {0, 1, 2, 3, full_depth}) {
                const ExampleFactors example(std::uint32_t(levels), count, levels, 0.5, depth);
                function_product(example.size, example.factors, depth, memory, blocks);
                std::array<Texels, cubemap_faces> wanted;
                for (std::size_t face = 0; face < cubemap_faces; ++face)
                    wanted[face] = reference::product(example.texels[face]);
                SCOPED_TRACE(testing::Message()
                             << levels << " levels, " << count << " factors, depth " << depth);
                expect_texels(texels_of(blocks, 0, example.size), wanted);
                expect_texels(texels_of(cubemap_tree(blocks), 0, example.size), wanted);
            }
}

TEST(FunctionProduct, WithLightEqualsTexelProductPerChannel) {
    WalkMemory<float> memory;
    std::vector<WaveletBlock<3>> blocks;
    for (const int levels : {2, 5})
        for (int count = 0; count <= 3; ++count) {
            const ExampleFactors example(std::uint32_t(levels), count, levels, 0.5);
            const RgbCubemapTree light = random_light(std::uint32_t(count), levels, 0.6);
            function_product(LightPyramid(light, example.size), example.factors, full_depth, memory, blocks);
            for (int channel = 0; channel < 3; ++channel) {
                std::array<Texels, cubemap_faces> wanted;
                for (std::size_t face = 0; face < cubemap_faces; ++face) {
                    std::vector<Texels> all = example.texels[face];
                    all.push_back(reference::texels_of(light.faces[face], channel, example.size));
                    wanted[face] = reference::product(all);
                }
                expect_texels(texels_of(blocks, channel, example.size), wanted);
                expect_texels(texels_of(cubemap_tree(blocks), channel, example.size), wanted);
            }
        }
}

TEST(FunctionProduct, IsAFunctionThatCanBeMultipliedAgain) {
    WalkMemory<float> memory;
    const ExampleFactors example(7, 5, 5, 0.6);
    const std::span<const WeightedTrees<float>> factors = example.factors;
    std::vector<WaveletBlock<1>> blocks;
    function_product(example.size, factors.first(3), full_depth, memory, blocks);
    const WideCubemapTree product(cubemap_tree(blocks));
    const std::array again{product.factor(), factors[3], factors[4]};
    double magnitude = 0;
    for (const auto& texels : example.texels)
        magnitude += reference::absolute_mean(reference::product(texels));
    EXPECT_NEAR(product_integral(example.size, again, full_depth, memory),
                product_integral(example.size, factors, full_depth, memory), 2e-6 * magnitude);
}

TEST(FunctionProduct, HasNoNodesWhereItIsConstantAndNoneWithoutWavelets) {
    WalkMemory<float> memory;
    std::vector<WaveletBlock<1>> blocks;
    function_product(64, {}, full_depth, memory, blocks);
    for (const Quadtree& face : cubemap_tree(blocks).faces) {
        EXPECT_EQ(face.scaling, 1);
        EXPECT_TRUE(face.nodes.empty());
    }
    // Open except for one texel: each level has one node.
    std::vector<float> texels(6 * 64 * 64, 1.0f);
    texels[4 * 64 * 64 + 17] = 0;
    const CubemapTree dot = haar_cubemap<float>(texels, 64);
    const WideCubemapTree wide(dot);
    function_product(64, std::array{wide.factor(), wide.factor()}, full_depth, memory, blocks);
    const CubemapTree found = cubemap_tree(blocks);
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        EXPECT_EQ(found.faces[face].nodes.size(), face == 4 ? 6u : 0u);
}

TEST(ProductIntegral, AgreesBetweenInstructionSets) {
    WalkMemory<float> memory;
    const LightPyramid light(random_light(5, 6, 0.6), 64);
    const ExampleFactors example(5, 4, 6, 0.6);
    const Rgb wanted = product_integral(light, example.factors, full_depth, memory);
    const std::int64_t all = hwy::SupportedTargets();
    for (std::int64_t left = all; left != 0; left &= left - 1) {
        hwy::SetSupportedTargetsForTest(left & -left);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        const Rgb found = product_integral(light, example.factors, full_depth, memory);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], wanted[c], 1e-5 * std::abs(wanted[c])) << hwy::TargetName(left & -left);
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace
}  // namespace haarfield
