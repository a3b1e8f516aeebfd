#include "shading/walk/vertex_shading.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <map>
#include <random>

#include "fields/wavelets/haar_transform.h"
#include "shading/transfer/coefficient_energies.h"
#include "shading/walk/wide_visibility.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/random_numbers.h"
#include "tests/fixtures/vertex_example.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

constexpr int size = VertexExample::size;

/// Compares radiance relative to the unoccluded reflected radiance, about `reflected`.
void expect_near(const Rgb& found, const Vec3d& wanted, double reflected, double tolerance) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], wanted[c], tolerance * reflected);
}

TEST(VertexShading, DiffuseEqualsTheSumOverTexels) {
    std::mt19937 random(1);
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        const VertexExample example(seed);
        for (int i = 0; i < 6; ++i) {
            VertexBrdf brdf;
            brdf.normal = random_direction(random);
            brdf.mirror = brdf.normal;
            brdf.diffuse = Rgb(0.3f, 0.2f, 0.1f);
            SCOPED_TRACE(testing::Message() << "seed " << seed << ", normal " << brdf.normal);
            expect_near(example.found(brdf, {}), example.expected(brdf, {}), 0.3, 1e-3);
        }
    }
}

TEST(VertexShading, ConcentratedLightMeetsTheCosineThatItHas) {
    // A texel in a corner of its block of 4 x 4, on each face: the cosine at the block's centre differs.
    RgbCubemapTree light;
    for (RgbQuadtree& face : light.faces) {
        std::vector<Rgb> texels(size * size, Rgb(0.0f));
        texels[(24 * size) + 40] = Rgb(1000.0f);
        face = haar_quadtree<Rgb>(texels, size, {});
    }
    const LightPyramid pyramid(light, size);
    const DirectionPyramid directions(size);
    WalkMemory<std::uint8_t> memory;
    std::mt19937 random(5);
    for (int i = 0; i < 20; ++i) {
        VertexBrdf brdf;
        brdf.normal = brdf.mirror = random_direction(random);
        brdf.diffuse = Rgb(1.0f);
        double expected = 0;
        for (int face = 0; face < int(cubemap_faces); ++face)
            expected += 1000 * std::max(0.0f, texel_direction(face, 40, 24, size).dot(brdf.normal));
        expected /= size * size;
        EXPECT_NEAR(outgoing_radiance(pyramid, {directions, brdf, {}, full_depth}, memory).diffuse.x,
                    expected, 5e-3 * expected)
            << brdf.normal;
    }
}

TEST(VertexShading, SpecularLobesEqualTheSumOverTexels) {
    std::mt19937 random(2);
    const VertexExample example(7);
    for (const float shininess : {1.0f, 5.0f, 30.0f, 60.0f, 200.0f, 1000.0f})
        for (const bool cosine_weighted : {true, false})
            for (int i = 0; i < 6; ++i) {
                VertexBrdf brdf;
                brdf.normal = random_direction(random);
                brdf.mirror = (random_direction(random) + brdf.normal).normalized();
                brdf.specular = Rgb(1.0f);
                brdf.lobes[0] = {LobeAxis::mirror, 1, shininess};
                brdf.cosine_weighted = cosine_weighted;
                SCOPED_TRACE(testing::Message() << "shininess " << shininess << ", mirror " << brdf.mirror
                                                << (cosine_weighted ? ", cosine" : ""));
                expect_near(example.found(brdf, {}), example.expected(brdf, {}),
                            2 * pi / (double(shininess) + 1), 0.02);
            }
}

/// Relative to the reflected radiance if the eye is above the surface.
TEST(VertexShading, BlinnLobesEqualTheSumOverTexels) {
    std::mt19937 random(12);
    const VertexExample example(7);
    for (const float exponent : {1.0f, 5.0f, 20.0f, 60.0f, 200.0f, 1000.0f, 2000.0f})
        for (int i = 0; i < 12; ++i) {
            VertexBrdf brdf;
            brdf.normal = random_direction(random);
            brdf.mirror = (random_direction(random) + brdf.normal).normalized();
            brdf.specular = Rgb(1.0f);
            brdf.lobes[0] = {LobeAxis::half_vector, 1, exponent};
            SCOPED_TRACE(testing::Message() << "exponent " << exponent << ", eye at "
                                            << std::acos(brdf.normal.dot(brdf.mirror)) * 180 / pi);
            expect_near(example.found(brdf, {}), example.expected(brdf, {}), 8 * pi / (double(exponent) + 4),
                        exponent > 1000 ? 0.03 : 0.02);
        }
}

TEST(VertexShading, MetallicLobesEqualTheSumOverTexels) {
    std::mt19937 random(13);
    const VertexExample example(7);
    for (const float exponent : {2.0f, 30.0f, 300.0f})
        for (int i = 0; i < 12; ++i) {
            VertexBrdf brdf;
            brdf.normal = random_direction(random);
            brdf.mirror = (random_direction(random) + brdf.normal).normalized();
            brdf.diffuse = Rgb(0.1f);
            brdf.specular = Rgb(1.0f);
            brdf.lobes = {{{LobeAxis::mirror, 0.5f, exponent}, {LobeAxis::half_vector, 0.5f, 4 * exponent}}};
            brdf.metallic = Rgb(0.2f, 0.6f, 1);
            SCOPED_TRACE(testing::Message() << "exponent " << exponent << ", eye at "
                                            << std::acos(brdf.normal.dot(brdf.mirror)) * 180 / pi);
            expect_near(example.found(brdf, {}), example.expected(brdf, {}),
                        0.1 + 2 * pi / (double(exponent) + 1), 0.02);
        }
}

TEST(VertexShading, BlockedConesAreExact) {
    std::mt19937 random(3);
    const VertexExample example(9);
    const Mesh meshes[] = {square_mesh(2, -0.5f), box_mesh({-0.5f, 0.3f, -0.5f}, {0.5f, 1, 0.6f}),
                           joined_meshes(box_mesh({0.4f, -1, -1}, {0.5f, 1, 1}), square_mesh(3, 1.2f))};
    for (const Mesh& mesh : meshes) {
        BlockedConeList cones;
        add_cones(convex_polygons(make_occluder(mesh)), Vec3f(0.1f, 0.05f, -0.08f), cones);
        ASSERT_FALSE(cones.end.empty());
        for (int i = 0; i < 6; ++i) {
            VertexBrdf brdf;
            brdf.normal = random_direction(random);
            brdf.mirror = brdf.normal;
            brdf.diffuse = Rgb(0.3f);
            expect_near(example.found(brdf, cones), example.expected(brdf, cones), 0.3, 2e-3);
        }
    }
}

TEST(VertexShading, AVertexUnderACoverIsBlack) {
    const VertexExample example(4);
    BlockedConeList cones;
    add_cones(convex_polygons(make_occluder(square_mesh(1000, 1e-3f))), Vec3f(0.0f), cones);
    VertexBrdf brdf;
    brdf.normal = {0, 1, 0};
    brdf.mirror = {0, 1, 0};
    brdf.diffuse = Rgb(1.0f);
    EXPECT_NEAR(example.found(brdf, cones).x, 0, 1e-5);
}

TEST(VertexShading, LessDepthIsCoarserButNear) {
    std::mt19937 random(5);
    const VertexExample example(11);
    double before = 0;
    for (const int depth : {6, 4, 2, 0}) {
        double error = 0;
        random.seed(5);
        for (int i = 0; i < 10; ++i) {
            VertexBrdf brdf;
            brdf.normal = random_direction(random);
            brdf.mirror = brdf.normal;
            brdf.diffuse = Rgb(0.3f);
            error +=
                std::abs(double(example.found(brdf, {}, depth).x) / example.expected(brdf, {}).x - 1) / 10;
        }
        EXPECT_GE(error, before) << depth;
        EXPECT_LT(error, depth == 6 ? 2e-3 : depth == 4 ? 0.02 : 2) << depth;
        before = error;
    }
}

TEST(VertexShading, ComponentsAreThoseOfVerticesWithOneTermAlone) {
    std::mt19937 random(8);
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
        const VertexExample example(20 + seed);
        const BlockedConeList cones = seed % 2 ? cones_of_a_square() : BlockedConeList();
        for (int i = 0; i < 20; ++i) {
            VertexBrdf brdf;
            brdf.normal = random_direction(random);
            brdf.mirror = (random_direction(random) + brdf.normal).normalized();
            brdf.diffuse = Rgb(0.3f, 0.2f, 0.1f);
            brdf.specular = Rgb(0.1f, 0.2f, 0.3f);
            brdf.lobes = {{{LobeAxis::mirror, 1, i % 3 ? 30.0f : 3.0f},
                           {LobeAxis::half_vector, i % 5 ? 0.0f : 0.5f, 20}}};
            brdf.metallic = i % 4 ? Rgb(0.0f) : Rgb(0.2f, 0.4f, 0.8f);
            VertexBrdf matte = brdf, mirror = brdf;
            matte.specular = mirror.diffuse = Rgb(0.0f);
            for (const int depth : {4, full_depth}) {
                SCOPED_TRACE(testing::Message()
                             << "seed " << seed << ", vertex " << i << ", depth " << depth);
                const Outgoing found = example.components(brdf, cones, depth),
                               diffuse = example.components(matte, cones, depth),
                               specular = example.components(mirror, cones, depth);
                EXPECT_EQ(diffuse.specular, Rgb(0.0f));
                EXPECT_EQ(specular.diffuse, Rgb(0.0f));
                EXPECT_LT((found.diffuse - diffuse.diffuse).length(), 1e-3f * brdf.diffuse.length());
                EXPECT_LT((found.specular - specular.specular).length(), 1e-5f * specular.specular.length());
            }
        }
    }
}

/// Returns the coefficients of an RGB product by index (sparse_vectors.h).
std::map<std::uint32_t, Vec3d> coefficients_of(const std::vector<WaveletBlock<3>>& product) {
    std::map<std::uint32_t, Vec3d> result;
    const BlockNumbers numbers(size);
    for (const WaveletBlock<3>& block : product)
        for (std::uint32_t slot = 0; slot < wide_cells; ++slot) {
            const double of_amplitude =
                double(coefficient_of_amplitude(level_of_block(numbers, block.block), slot));
            for (int c = 0; c < 3; ++c)
                result[16 * block.block + slot][c] =
                    of_amplitude * double(block.amplitude[std::size_t(c)][slot]);
        }
    return result;
}

TEST(RadianceIntegrand, BlurredDetailIsWithinItsBoundAndKeepsItsMeans) {
    constexpr CoefficientSpectrum spectrum{1, 0.8f, 0.6f, 0.3f, 0.2f, 0.1f, 0.05f};
    std::mt19937 random(9);
    WalkMemory<std::uint8_t> memory;
    std::vector<WaveletBlock<3>> product;
    int fewer = 0;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        const VertexExample example(30 + seed);
        const BlockedConeList cones = seed % 2 ? cones_of_a_square() : BlockedConeList();
        for (int i = 0; i < 16; ++i) {
            VertexBrdf brdf;
            brdf.normal = random_direction(random);
            brdf.mirror = i % 2 ? brdf.normal : (random_direction(random) + brdf.normal).normalized();
            brdf.diffuse = i % 4 ? Rgb(0.3f, 0.2f, 0.1f) : Rgb(0.0f);
            brdf.specular = i % 3 ? Rgb(0.1f, 0.2f, 0.3f) : Rgb(0.0f);
            brdf.lobes[0] = {LobeAxis::mirror, 1, i % 2 ? 0.0f : 20.0f};
            brdf.cosine_weighted = i % 8 < 4;
            const auto made = [&](const DetailWeights* detail) {
                const double bound =
                    radiance_integrand(*example.light, example.shaded(brdf, cones), memory, product, detail);
                return std::pair(coefficients_of(product), bound);
            };
            const auto [whole, nothing] = made(nullptr);
            EXPECT_EQ(nothing, 0);
            for (const double energy : {1e-9, 1e-7, 1e-5}) {
                const DetailWeights detail = detail_weights(spectrum, energy);
                const auto [blurred, bound] = made(&detail);
                double missing = 0;
                for (const auto& [index, wanted] : whole) {
                    const auto found = blurred.find(index);
                    const Vec3d difference = wanted - (found == blurred.end() ? Vec3d(0.0) : found->second);
                    const double weight = double(
                        spectrum[spectrum_place(level_of_block(BlockNumbers(size), index / 16), index % 16)]);
                    // Blocks above keep their coefficients, except for the rounding of means to bytes.
                    if (found == blurred.end())
                        missing += difference.dot(difference) * weight * weight;
                    else
                        EXPECT_LT(difference.length(), 2e-3);
                }
                EXPECT_LE(missing, bound * 1.0001 + 1e-14) << seed << ", " << i << ", " << energy;
                EXPECT_LE(bound, energy * 2000);
                EXPECT_LE(blurred.size(), whole.size());
                fewer += blurred.size() < whole.size();
            }
        }
    }
    EXPECT_GT(fewer, 60);
}

/// If only one channel of the light varies, the bound is exact.
TEST(RadianceIntegrand, TheBoundOfBlurredDetailIsTightForLightAlone) {
    RgbCubemapTree tree;
    for (std::uint32_t face = 0; face < cubemap_faces; ++face) {
        std::vector<Rgb> texels;
        for (const float value : reference::noise_texels(70 + face, size * size))
            texels.emplace_back(value, 0, 0);
        tree.faces[face] = haar_quadtree<Rgb>(texels, size, {});
    }
    const LightPyramid light(tree, size);
    const DirectionPyramid directions(size);
    WalkMemory<std::uint8_t> memory;
    std::vector<WaveletBlock<3>> product;
    VertexBrdf brdf;
    brdf.normal = brdf.mirror = Vec3f(0, 1, 0);
    brdf.specular = Rgb(0.5f);
    brdf.lobes[0] = {LobeAxis::mirror, 1, 0};
    CoefficientSpectrum spectrum;
    spectrum.fill(1);
    radiance_integrand(light, {directions, brdf, {}, full_depth}, memory, product);
    const auto whole = coefficients_of(product);
    // The cells of one level: in larger ones, the horizon is uncertain.
    const DetailWeights detail = detail_weights(spectrum, 3e-4);
    const double bound =
        radiance_integrand(light, {directions, brdf, {}, full_depth}, memory, product, &detail);
    const auto blurred = coefficients_of(product);
    double missing = 0;
    for (const auto& [index, wanted] : whole)
        if (blurred.count(index) == 0) missing += wanted.dot(wanted);
    EXPECT_GT(missing, 0);
    EXPECT_LE(missing, bound * 1.0001);
    EXPECT_LE(bound, missing * 1.3);
}

TEST(SpecularIntegrand, ComesWithTheDiffuseRadiance) {
    constexpr CoefficientSpectrum spectrum{1, 0.8f, 0.6f, 0.3f, 0.2f, 0.1f, 0.05f};
    const DetailWeights coarse = detail_weights(spectrum, 1e-6);
    std::mt19937 random(11);
    WalkMemory<std::uint8_t> memory;
    std::vector<WaveletBlock<3>> product;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        const VertexExample example(50 + seed);
        const BlockedConeList cones = seed % 2 ? cones_of_a_square() : BlockedConeList();
        for (int i = 0; i < 16; ++i) {
            VertexBrdf brdf;
            brdf.normal = brdf.mirror = random_direction(random);
            brdf.diffuse = Rgb(0.3f, 0.2f, 0.1f);
            brdf.specular = Rgb(0.1f, 0.2f, 0.3f);
            brdf.lobes[0] = {LobeAxis::mirror, 1, i % 2 ? 0.0f : 20.0f};
            brdf.metallic = i % 3 ? Rgb(0.0f) : Rgb(0.2f, 0.4f, 0.8f);
            VertexBrdf highlights = brdf, rest = brdf;
            highlights.diffuse = rest.specular = Rgb(0.0f);
            const Vec3d wanted = example.expected(rest, cones);
            for (const DetailWeights* detail : {static_cast<const DetailWeights*>(nullptr), &coarse}) {
                const double bound = radiance_integrand(*example.light, example.shaded(highlights, cones),
                                                        memory, product, detail);
                const auto coefficients = coefficients_of(product);
                const SpecularIntegrand found =
                    specular_integrand(*example.light, example.shaded(brdf, cones), memory, product, detail);
                EXPECT_EQ(found.blurred_energy, bound);
                EXPECT_EQ(coefficients_of(product), coefficients);
                SCOPED_TRACE(testing::Message() << "seed " << seed << ", vertex " << i);
                expect_near(found.diffuse, wanted, 0.3, 1e-3);
            }
        }
    }
}

TEST(VertexShading, AgreesBetweenInstructionSets) {
    const VertexExample example(13);
    const BlockedConeList cones = cones_of_a_square();
    VertexBrdf brdf;
    brdf.normal = Vec3f(0.2f, 0.7f, 0.3f).normalized();
    brdf.mirror = Vec3f(0.6f, 0.5f, 0.1f).normalized();
    brdf.diffuse = Rgb(0.3f);
    brdf.specular = Rgb(1.0f);
    brdf.lobes = {{{LobeAxis::mirror, 1, 40}, {LobeAxis::half_vector, 0.5f, 20}}};
    brdf.metallic = Rgb(0.2f, 0.4f, 0.8f);
    const Rgb wanted = example.found(brdf, cones);
    const std::int64_t all = hwy::SupportedTargets();
    for (std::int64_t left = all; left != 0; left &= left - 1) {
        hwy::SetSupportedTargetsForTest(left & -left);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        const Rgb found = example.found(brdf, cones);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], wanted[c], 1e-5 * wanted[c]) << hwy::TargetName(left & -left);
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace
}  // namespace haarfield
