/// Tests that each baseline computes the right result.

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>

#include "fields/wavelets/haar_transform.h"
#include "tests/baselines/dense_product.h"
#include "tests/baselines/general_basis.h"
#include "tests/baselines/harmonics_product.h"
#include "tests/baselines/pairwise_product.h"
#include "tests/baselines/product_methods.h"
#include "tests/baselines/ray_casting.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield::baseline {
namespace {

using reference::pointers;
using reference::random_trees;
using reference::Texels;

TEST(PairwiseProduct, EqualsTexelProduct) {
    for (int levels = 0; levels <= 5; ++levels)
        for (std::uint32_t seed = 0; seed < 10; ++seed) {
            const Quadtree f = reference::random_quadtree(seed, levels, 0.6),
                           g = reference::random_quadtree(100 + seed, 4, 0.5);
            LinkedQuadtree product{7, {{}, {}}};
            pairwise_product(linked_quadtree(f), linked_quadtree(g), product);
            // One node per line, in the tree's order: read back by following the links.
            const int size = 32;
            const Texels expected = reference::product(
                std::vector<Texels>{reference::texels_of(f, size), reference::texels_of(g, size)});
            EXPECT_NEAR(product.scaling, reference::mean(expected),
                        1e-6 * reference::absolute_mean(expected));
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) {
                    double value = double(product.scaling);
                    std::int32_t index = product.nodes.empty() ? no_node : 0;
                    for (int side = size; side > 1 && index != no_node; side /= 2) {
                        const bool right = x % side >= side / 2, low = y % side >= side / 2;
                        const auto& node = product.nodes[std::size_t(index)];
                        value += double(node.wavelet[0]) * (right ? -1 : 1) +
                                 double(node.wavelet[1]) * (low ? -1 : 1) +
                                 double(node.wavelet[2]) * (right != low ? -1 : 1);
                        index = node.child[(low ? 2u : 0u) + (right ? 1u : 0u)];
                    }
                    ASSERT_NEAR(value, expected[std::size_t(y * size + x)], 1e-5) << levels << ", " << seed;
                }
        }
}

TEST(PairwiseProduct, OfAllFactorsIntegratesToTheTexelSum) {
    RecursivePairwiseProduct recursive;
    for (int count = 1; count <= 6; ++count)
        for (std::uint32_t seed = 0; seed < 5; ++seed) {
            const RgbQuadtree light = reference::random_rgb_quadtree(seed, 5, 0.6);
            const auto trees = random_trees(seed, count, 5, 0.5);
            std::vector<LinkedQuadtree> linked;
            for (const Quadtree& tree : trees) linked.push_back(linked_quadtree(tree));
            std::vector<const LinkedQuadtree*> factors;
            for (const LinkedQuadtree& tree : linked) factors.push_back(&tree);
            const Rgb integral = recursive(light, factors);
            for (int channel = 0; channel < 3; ++channel) {
                std::vector<Texels> texels{reference::texels_of(light, channel, 32)};
                for (const Quadtree& tree : trees) texels.push_back(reference::texels_of(tree, 32));
                const Texels product = reference::product(texels);
                EXPECT_NEAR(integral[channel], reference::mean(product),
                            2e-6 * reference::absolute_mean(product))
                    << count << " factors, seed " << seed;
            }
        }
}

TEST(GeneralBasis, RecursionEqualsTheTexelSum) {
    for (int levels = 0; levels <= 3; ++levels) {
        const RecursiveGeneralBasis recursive(levels);
        for (int count = 2; count <= 5; ++count) {
            const auto trees = random_trees(std::uint32_t(count), count, levels, 0.8);
            std::vector<std::vector<float>> functions;
            std::vector<Texels> texels;
            for (const Quadtree& tree : trees) {
                const std::vector<double> coefficients = basis_coefficients(tree, levels);
                functions.emplace_back(coefficients.begin(), coefficients.end());
                texels.push_back(reference::texels_of(tree, 1 << levels));
            }
            const Texels product = reference::product(texels);
            EXPECT_NEAR(recursive(functions), reference::mean(product),
                        1e-5 * reference::absolute_mean(product))
                << levels << " levels, " << count << " functions";
        }
    }
}

TEST(Harmonics, AreOrthonormal) {
    // The value at a texel's centre is used for the whole texel: an error of about (1/size)^2 times the
    // squared degree.
    const int order = 5, size = 64;
    std::vector<double> products(std::size_t(order * order) * std::size_t(order * order), 0.0);
    for (int face = 0; face < cubemap_faces; ++face)
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column) {
                const auto values = harmonics(order, Vec3d(texel_direction(face, column, row, size)));
                for (std::size_t i = 0; i < values.size(); ++i)
                    for (std::size_t j = 0; j < values.size(); ++j)
                        products[i * values.size() + j] +=
                            values[i] * values[j] * texel_solid_angle(column, row, size);
            }
    for (std::size_t i = 0; i < 25; ++i)
        for (std::size_t j = 0; j < 25; ++j)
            EXPECT_NEAR(products[i * 25 + j], i == j ? 1 : 0, 2e-3) << i << ", " << j;
}

TEST(Harmonics, AreTheKnownPolynomials) {
    const Vec3d d = Vec3d(0.3, -0.5, 0.7).normalized();
    const std::vector<double> values = harmonics(3, d);
    EXPECT_NEAR(values[0], 0.282094791773878, 1e-14);
    EXPECT_NEAR(values[1], 0.488602511902920 * d.z, 1e-14);
    EXPECT_NEAR(values[2], 0.488602511902920 * d.y, 1e-14);
    EXPECT_NEAR(values[3], 0.488602511902920 * d.x, 1e-14);
    EXPECT_NEAR(values[4], 1.092548430592079 * d.x * d.z, 1e-14);
    EXPECT_NEAR(values[5], 1.092548430592079 * d.y * d.z, 1e-14);
    EXPECT_NEAR(values[6], 0.315391565252520 * (3 * d.y * d.y - 1), 1e-14);
    EXPECT_NEAR(values[7], 1.092548430592079 * d.x * d.y, 1e-14);
    EXPECT_NEAR(values[8], 0.546274215296040 * (d.x * d.x - d.z * d.z), 1e-14);
}

TEST(Harmonics, ProductIsThatOfTheFunctionsWhereTheOrderSuffices) {
    // Functions of degree 2 have products of degree 4, which order 5 can represent.
    const int order = 5;
    const TriplingCoefficients coefficients = tripling_coefficients(order);
    HarmonicsBatch f(25 * harmonics_batch), g = f, product;
    const std::vector<float> noise = reference::noise_texels(3, 2 * 9 * harmonics_batch);
    for (std::size_t i = 0; i < 9 * harmonics_batch; ++i) {
        f[i] = noise[2 * i] - 0.5f;
        g[i] = noise[2 * i + 1] - 0.5f;
    }
    harmonics_product(coefficients, f, g, product);
    const auto value = [&](const HarmonicsBatch& function, const std::vector<double>& basis,
                           std::size_t lane) {
        double sum = 0;
        for (std::size_t k = 0; k < basis.size(); ++k)
            sum += double(function[k * harmonics_batch + lane]) * basis[k];
        return sum;
    };
    for (int i = 0; i < 20; ++i) {
        const auto basis = harmonics(order, Vec3d(std::cos(i), 0.3 * i - 3, std::sin(1.7 * i)).normalized());
        for (std::size_t lane = 0; lane < harmonics_batch; ++lane)
            EXPECT_NEAR(value(product, basis, lane), value(f, basis, lane) * value(g, basis, lane), 1e-5)
                << "direction " << i << ", lane " << lane;
    }
}

TEST(SceneIntegrals, AllMethodsAgreeWithTheSumsOverTheirTexels) {
    for (const int functions : {3, 6, 7}) {
        const TexelIntegrals texels = texel_integrals(32, 20);
        const TreeIntegrals trees = tree_integrals(texels, functions, {60, 40});
        const std::vector<Vec3d> exact = texel_sums(texels, functions), truncated = texel_sums(trees);
        for (const NamedMethod& named : all_methods()) {
            const Method method = named.make({texels, trees, functions});
            const std::vector<Rgb> radiance = radiance_by(method, texels.vertices.size());
            EXPECT_LT(relative_rmse(radiance, method.of_trees ? truncated : exact), method.tolerance)
                << named.name << ", " << functions << " functions";
        }
    }
}

TEST(SceneIntegrals, AllMethodsAgreeAtEveryDepth) {
    const TexelIntegrals texels = texel_integrals(32, 5);
    const TreeIntegrals trees = tree_integrals(texels, 6);
    for (int depth = 0; depth <= 5; ++depth) {
        const std::vector<Vec3d> wanted = texel_sums(trees, depth);
        for (const Method& method :
             {haarfield_method(trees, depth), narrow_method(trees, depth), paper_method(trees, depth)})
            EXPECT_LT(relative_rmse(radiance_by(method, 5), wanted), method.tolerance)
                << method.title << ", " << depth;
    }
}

/// Returns functions that bytes, half floats and, if `whole`, bits represent exactly. Most open texels are in
/// few blocks, and some blocks have only one open texel.
TexelIntegrals exactly_stored_integrals(bool whole, std::uint32_t seed) {
    TexelIntegrals integrals;
    integrals.face_size = 16;
    const std::size_t texels = cubemap_faces * 16 * 16;
    const std::vector<float> noise = reference::noise_texels(seed, 8 * texels);
    VertexTexels vertex;
    vertex.factors.resize(5, std::vector<float>(texels));
    for (std::size_t i = 0; i < texels; ++i) {
        const float* const n = &noise[8 * i];
        integrals.light.emplace_back(n[0], n[1], n[2]);
        vertex.factors[0][i] = std::round(255 * n[3]) / 255;
        vertex.factors[1][i] = std::round(256 * n[4]) / 64;
        for (std::size_t k = 2; k < 5; ++k) {
            const float open = whole ? std::round(n[k + 3]) : std::round(8 * n[k + 3]) / 8;
            vertex.factors[k][i] = i % 97 < 80 && i % 89 != 0 ? 0 : open;
        }
    }
    integrals.vertices.push_back(std::move(vertex));
    return integrals;
}

TEST(DenseProduct, IsExactForAllInstructionSets) {
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        hwy::SetSupportedTargetsForTest(target);
        for (std::uint32_t seed = 0; seed < 20; ++seed)
            for (const bool whole : {false, true})
                for (int functions = 3; functions <= 6; ++functions) {
                    const TexelIntegrals texels = exactly_stored_integrals(whole, seed);
                    const std::vector<Vec3d> exact = texel_sums(texels, functions);
                    std::vector<Method> methods{
                        dense_scalar_method(texels, functions), dense_method(texels, functions),
                        dense_open_method(texels, functions), dense_bytes_method(texels, functions)};
                    if (whole) methods.push_back(dense_bits_method(texels, functions));
                    for (const Method& method : methods)
                        EXPECT_LT(relative_rmse(radiance_by(method, 1), exact), 2e-6)
                            << method.title << ", " << hwy::TargetName(target) << ", seed " << seed << ", "
                            << functions << " functions";
                }
    }
    hwy::SetSupportedTargetsForTest(0);
}

TEST(RayCaster, ConvergesToTheTexelSums) {
    constexpr std::uint32_t vertices = 256;  // enough for some below the surface
    const TexelIntegrals texels = texel_integrals(64, vertices);
    const std::vector<Vec3d> exact = texel_sums(texels, 7);
    RayCaster caster(shipped_scene(), texels);
    double last = INFINITY;
    for (const int rays : {16, 256, 4096}) {
        caster.use_rays(rays);
        std::vector<Rgb> radiance;
        for (std::uint32_t v = 0; v < vertices; ++v) radiance.push_back(caster(texels.vertices[v], v));
        const double error = relative_rmse(radiance, exact);
        EXPECT_LT(error, last / 2) << rays << " rays";
        last = error;
    }
    EXPECT_LT(last, 0.003);
}

}  // namespace
}  // namespace haarfield::baseline
