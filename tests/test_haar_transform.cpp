#include "fields/wavelets/haar_transform.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

using reference::Texels;

Texels in_double(const std::vector<float>& texels) {
    return Texels(texels.begin(), texels.end());
}

std::vector<Rgb> noise_colours(std::uint32_t seed, std::size_t count) {
    const std::vector<float> values = reference::noise_texels(seed, 3 * count);
    std::vector<Rgb> colours;
    for (std::size_t i = 0; i < values.size(); i += 3)
        colours.push_back(Rgb(values[i], values[i + 1], values[i + 2]));
    return colours;
}

/// Calls visit(node, level, x, y) for every node.
template <class Value, class Visit>
void visit_nodes(const BasicQuadtree<Value>& tree, const Visit& visit) {
    const std::function<void(std::int32_t, int, int, int)> walk = [&](std::int32_t index, int level, int x,
                                                                      int y) {
        const auto& node = tree.nodes[std::size_t(index)];
        visit(node, level, x, y);
        for (unsigned q = 0; q < 4; ++q)
            if (const std::int32_t child = child_of(node, q); child != no_node)
                walk(child, level + 1, 2 * x + int(q % 2), 2 * y + int(q / 2));
    };
    if (!tree.nodes.empty()) walk(0, 0, 0, 0);
}

/// Counts non-zero wavelets; an Rgb wavelet counts once.
template <class Value>
int wavelet_count(const BasicQuadtree<Value>& tree) {
    int count = 0;
    visit_nodes(tree, [&](const auto& node, int, int, int) {
        for (const Value& wavelet : node.wavelet) count += wavelet != Value(0.0f);
    });
    return count;
}

/// Returns the energies of all wavelets of a function, largest first, by summation over their squares.
std::vector<double> wavelet_energies(const Texels& texels, int size) {
    std::vector<double> energies;
    for (int level = 0; 1 << level < size; ++level)
        for (int y = 0; y < 1 << level; ++y)
            for (int x = 0; x < 1 << level; ++x)
                for (int kind = 0; kind < 3; ++kind) {
                    const double amplitude = reference::wavelet_amplitude(texels, size, level, x, y, kind);
                    energies.push_back(std::ldexp(amplitude * amplitude, -2 * level));
                }
    std::sort(energies.begin(), energies.end(), std::greater<>());
    return energies;
}

double squared_distance(const Texels& a, const Texels& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum / double(a.size());
}

TEST(HaarTransform, RoundTripsForAllSizes) {
    for (int size = 1; size <= 256; size *= 2) {
        const std::vector<float> texels =
            reference::noise_texels(std::uint32_t(size), std::size_t(size * size));
        const Quadtree tree = haar_quadtree<float>(texels, size);
        const std::vector<float> back = quadtree_texels(tree, size);
        const Texels by_reference = reference::texels_of(tree, size);
        for (std::size_t i = 0; i < texels.size(); ++i) {
            ASSERT_NEAR(back[i], texels[i], 1e-6) << "size " << size << ", texel " << i;
            ASSERT_NEAR(by_reference[i], double(texels[i]), 1e-6) << "size " << size << ", texel " << i;
        }
    }
}

TEST(HaarTransform, RoundTripsColoursForAllSizes) {
    for (int size = 1; size <= 256; size *= 2) {
        const std::vector<Rgb> texels = noise_colours(std::uint32_t(size), std::size_t(size * size));
        const RgbQuadtree tree = haar_quadtree<Rgb>(texels, size);
        const std::vector<Rgb> back = quadtree_texels(tree, size);
        for (int channel = 0; channel < 3; ++channel) {
            const Texels by_reference = reference::texels_of(tree, channel, size);
            for (std::size_t i = 0; i < texels.size(); ++i) {
                ASSERT_NEAR(back[i][channel], texels[i][channel], 1e-6) << size << ", " << i;
                ASSERT_NEAR(by_reference[i], double(texels[i][channel]), 1e-6) << size << ", " << i;
            }
        }
    }
}

TEST(HaarTransform, HoldsTheAmplitudesThatTheDefinitionGives) {
    for (const int size : {2, 4, 16}) {
        const std::vector<float> texels = reference::noise_texels(77, std::size_t(size * size));
        const Texels exact = in_double(texels);
        int nodes = 0;
        const Quadtree tree = haar_quadtree<float>(texels, size);
        visit_nodes(tree, [&](const Quadtree::Node& node, int level, int x, int y) {
            ++nodes;
            for (int kind = 0; kind < 3; ++kind)
                EXPECT_NEAR(node.wavelet[std::size_t(kind)],
                            reference::wavelet_amplitude(exact, size, level, x, y, kind), 1e-6)
                    << size << ": level " << level << ", " << x << ", " << y << ", kind " << kind;
        });
        EXPECT_EQ(nodes, (size * size - 1) / 3);
        EXPECT_NEAR(tree.scaling, reference::mean(exact), 1e-6);
    }
}

TEST(HaarTransform, KeepsTheL2NormOfTheFunction) {
    for (int size = 1; size <= 256; size *= 4) {
        const std::vector<float> texels = reference::half_plane_texels(std::uint32_t(size), size);
        const Quadtree tree = haar_quadtree<float>(texels, size);
        double norm = double(tree.scaling) * double(tree.scaling);
        visit_nodes(tree, [&](const Quadtree::Node& node, int level, int, int) {
            for (const float wavelet : node.wavelet)
                norm += std::ldexp(double(wavelet) * double(wavelet), -2 * level);
        });
        const Texels exact = in_double(texels);
        EXPECT_NEAR(norm, reference::mean(reference::product(std::vector<Texels>{exact, exact})), 1e-6)
            << size;
    }
}

TEST(HaarTransform, OfAConstantHasNoNodes) {
    for (int size = 1; size <= 64; size *= 2) {
        const Quadtree tree = haar_quadtree<float>(std::vector<float>(std::size_t(size * size), 0.3f), size);
        EXPECT_TRUE(tree.nodes.empty());
        EXPECT_FLOAT_EQ(tree.scaling, 0.3f);
    }
}

TEST(HaarTransform, KeepsTheCoefficientsWithTheLeastL2Error) {
    // No choice of m coefficients leaves less energy than that of all but the largest m.
    for (const int size : {4, 8, 32})
        for (const bool noise : {true, false}) {
            const std::vector<float> texels = noise ? reference::noise_texels(5, std::size_t(size * size))
                                                    : reference::half_plane_texels(5, size);
            const Texels exact = in_double(texels);
            const std::vector<double> energies = wavelet_energies(exact, size);
            for (const int kept : {1, 2, 7, 12, 70, 1000}) {
                const Quadtree tree = haar_quadtree<float>(texels, size, {kept, 0.0f});
                EXPECT_LE(wavelet_count(tree), kept);
                double least = 0;
                for (std::size_t i = std::size_t(kept); i < energies.size(); ++i) least += energies[i];
                EXPECT_NEAR(squared_distance(reference::texels_of(tree, size), exact), least, 1e-8)
                    << "size " << size << ", " << kept << " kept";
            }
        }
}

TEST(HaarTransform, KeepsTheBestOfAllSubsetsOnASmallFace) {
    // 15 wavelets: tests every subset of m of them.
    const std::vector<float> texels = reference::noise_texels(12, 16);
    const Texels exact = in_double(texels);
    const Quadtree full = haar_quadtree<float>(texels, 4);
    for (const int kept : {1, 3, 6}) {
        double least = 1e9;
        for (unsigned subset = 0; subset < 1u << 15; ++subset) {
            if (std::popcount(subset) != kept) continue;
            Quadtree tree = full;
            for (std::size_t i = 0; i < 15; ++i)
                if (!(subset >> i & 1u)) tree.nodes[i / 3].wavelet[i % 3] = 0;
            least = std::min(least, squared_distance(reference::texels_of(tree, 4), exact));
        }
        const Quadtree truncated = haar_quadtree<float>(texels, 4, {kept, 0.0f});
        EXPECT_NEAR(squared_distance(reference::texels_of(truncated, 4), exact), least, 1e-9) << kept;
    }
}

TEST(HaarTransform, DropsAllThatTheRelativeErrorAllowsAndNoMore) {
    const int size = 32;
    for (const std::uint32_t seed : {1u, 2u, 3u})
        for (const float error : {0.003f, 0.03f, 0.3f}) {
            const std::vector<float> texels = reference::half_plane_texels(seed, size);
            const Texels exact = in_double(texels);
            const double norm = reference::mean(reference::product(std::vector<Texels>{exact, exact}));
            const Quadtree tree = haar_quadtree<float>(texels, size, {0, error});
            EXPECT_LE(std::sqrt(squared_distance(reference::texels_of(tree, size), exact) / norm), error);
            // One coefficient fewer would exceed the error.
            const Quadtree next = haar_quadtree<float>(texels, size, {wavelet_count(tree) - 1, 0.0f});
            EXPECT_GT(std::sqrt(squared_distance(reference::texels_of(next, size), exact) / norm), error);
            // With both limits, the stricter one applies.
            EXPECT_EQ(wavelet_count(haar_quadtree<float>(texels, size, {3, error})),
                      std::min(3, wavelet_count(tree)));
        }
}

TEST(HaarTransform, LaysNodesOutAsATreeWithAncestors) {
    // Only fine detail: ancestors exist, with zeros.
    std::vector<float> texels(64 * 64, 0.0f);
    texels[64 * 41 + 22] = 1;
    texels[64 * 41 + 23] = -1;
    const Quadtree tree = haar_quadtree<float>(texels, 64, {1, 0.0f});
    ASSERT_EQ(tree.nodes.size(), 6u);
    EXPECT_EQ(wavelet_count(tree), 1);

    for (const std::uint32_t seed : {1u, 2u}) {
        const Quadtree other = haar_quadtree<float>(reference::half_plane_texels(seed, 64), 64, {50, 0.0f});
        // Level by level, siblings adjacent, each node once.
        std::size_t next = 1;
        for (const Quadtree::Node& node : other.nodes) {
            if ((node.children & 15u) == 0) continue;
            EXPECT_EQ(node.children >> 4, next);
            next += std::size_t(std::popcount(node.children & 15u));
        }
        EXPECT_EQ(next, other.nodes.size());
    }
}

TEST(HaarTransform, RanksColoursByTheirEuclideanMagnitude) {
    // Half differences along x: (0.6, 0.6, 0.6) has a larger norm than (1, 0, 0), although each channel is
    // smaller.
    const std::vector<Rgb> texels{Rgb(1, 0, 0) + Rgb(0.6f), Rgb(-1, 0, 0) + Rgb(0.6f),
                                  Rgb(1, 0, 0) - Rgb(0.6f), Rgb(-1, 0, 0) - Rgb(0.6f)};
    const RgbQuadtree tree = haar_quadtree<Rgb>(texels, 2, {1, 0.0f});
    ASSERT_EQ(tree.nodes.size(), 1u);
    EXPECT_EQ(tree.nodes[0].wavelet[0], Rgb(0.0f));
    for (int channel = 0; channel < 3; ++channel) EXPECT_FLOAT_EQ(tree.nodes[0].wavelet[1][channel], 0.6f);
}

TEST(HaarTransform, BreaksTiesTowardsTheCoarserLevelAndSmallerIndex) {
    // Equal pairs of texels far apart result in equal coefficients.
    std::vector<float> texels(16, 0.0f);
    texels[0] = texels[10] = 1;
    texels[1] = texels[11] = -1;
    const Quadtree tree = haar_quadtree<float>(texels, 4, {1, 0.0f});
    ASSERT_EQ(tree.nodes.size(), 2u);
    EXPECT_EQ(tree.nodes[0].children & 15u, 1u);  // the upper left square
    EXPECT_EQ(wavelet_count(tree), 1);
    EXPECT_NE(tree.nodes[1].wavelet[0], 0.0f);  // along x and diagonal are equal: the first is kept
}

TEST(QuadtreeTexels, AveragesOutWhatIsFinerThanItsTexels) {
    const Quadtree tree = reference::random_quadtree(4, 5, 0.8);
    const Texels fine = reference::texels_of(tree, 32);
    for (const int size : {1, 2, 8, 64}) {
        const std::vector<float> texels = quadtree_texels(tree, size);
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column) {
                double sum = 0;
                const int side = std::max(32 / size, 1);
                for (int y = 0; y < side; ++y)
                    for (int x = 0; x < side; ++x)
                        sum += fine[std::size_t((row * 32 / size + y) * 32 + column * 32 / size + x)];
                EXPECT_NEAR(texels[std::size_t(row * size + column)], sum / (side * side), 2e-6)
                    << size << ": " << row << ", " << column;
            }
    }
}

TEST(WeightedSum, EqualsTheSumOfTexels) {
    for (std::size_t count = 1; count <= 16; ++count)
        for (const int levels : {0, 1, 5}) {
            std::vector<Quadtree> trees;
            std::vector<RgbQuadtree> colours;
            std::vector<float> weights;
            for (std::uint32_t i = 0; i < count; ++i) {
                trees.push_back(reference::random_quadtree(i, std::max(0, levels - int(i % 3)), 0.5));
                colours.push_back(reference::random_rgb_quadtree(i, levels, 0.5));
                weights.push_back(0.3f - 0.07f * float(i));
            }
            std::vector<const Quadtree*> tree_pointers;
            std::vector<const RgbQuadtree*> colour_pointers;
            for (std::size_t i = 0; i < count; ++i) {
                tree_pointers.push_back(&trees[i]);
                colour_pointers.push_back(&colours[i]);
            }
            const int size = 1 << levels;
            const Texels sum = reference::texels_of(weighted_sum<float>(tree_pointers, weights), size);
            const RgbQuadtree colour_sum = weighted_sum<Rgb>(colour_pointers, weights);
            const Texels green = reference::texels_of(colour_sum, 1, size);
            Texels expected(sum.size(), 0.0), expected_green(sum.size(), 0.0);
            for (std::size_t i = 0; i < count; ++i) {
                const Texels texels = reference::texels_of(trees[i], size);
                const Texels colour_texels = reference::texels_of(colours[i], 1, size);
                for (std::size_t k = 0; k < sum.size(); ++k) {
                    expected[k] += double(weights[i]) * texels[k];
                    expected_green[k] += double(weights[i]) * colour_texels[k];
                }
            }
            for (std::size_t k = 0; k < sum.size(); ++k) {
                ASSERT_NEAR(sum[k], expected[k], 5e-6) << count << " trees, " << levels << " levels";
                ASSERT_NEAR(green[k], expected_green[k], 5e-6) << count << " trees, " << levels << " levels";
            }
        }
}

TEST(HaarCubemap, IsSixFacesInOrder) {
    const int size = 8;
    const std::vector<float> texels = reference::noise_texels(6, 6 * size * size);
    const CubemapTree cubemap = haar_cubemap<float>(texels, size);
    for (std::size_t face = 0; face < 6; ++face) {
        const Texels back = reference::texels_of(cubemap.faces[face], size);
        for (std::size_t i = 0; i < back.size(); ++i)
            ASSERT_NEAR(back[i], double(texels[face * 64 + i]), 1e-6) << face << ", " << i;
    }
}

}  // namespace
}  // namespace haarfield
