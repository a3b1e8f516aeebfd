#include "shading/transfer/lobe_vectors.h"

#include <gtest/gtest.h>

#include "fields/wavelets/haar_transform.h"
#include "shading/scene/lobes.h"

namespace haarfield {
namespace {

/// Evaluates a row, or an interpolation of rows, on texels, face by face.
std::vector<double> texels_of(const SparseVectorBlocks& vectors, const Interpolation& at, int size) {
    // Computes inner products with the box function of each texel.
    std::vector<double> texels(std::size_t(cubemap_faces * size * size), 0.0);
    std::vector<double> dense(coefficient_count(size), 0.0);
    for (int k = 0; k < at.count; ++k) {
        const std::uint32_t row = at.sample[std::size_t(k)];
        vectors.block_of(row).for_each(row % SparseVectorBlocks::block_rows,
                                       [&](std::uint32_t index, float value) {
                                           dense[index] += double(value) * double(at.weight[std::size_t(k)]);
                                       });
    }
    CoefficientSum box(size);
    for (std::size_t texel = 0; texel < texels.size(); ++texel) {
        std::vector<float> values(texels.size(), 0.0f);
        values[texel] = 1;
        box.clear();
        box.add(haar_cubemap<float>(values, size), 1);
        for (const std::uint32_t index : box.indices())
            texels[texel] += dense[index] * double(box[index]) * size * size;
    }
    return texels;
}

TEST(LobeVectors, AreTheLobesOfAllDirections) {
    const int size = 8;
    const float exponents[] = {30, 4, 30};
    const LobeVectors vectors = *lobe_vectors(*lobe_shapes(exponents, size, 0), {}, 0);
    EXPECT_EQ(vectors.first.size(), 2u);
    for (const float exponent : {4.0f, 30.0f})
        for (int i = 0; i < 40; ++i) {
            // Directions of all octants and all orders of their components, some of them on axes and
            // diagonals.
            const Vec3f direction =
                Vec3f(float(i % 5 - 2), float(i % 7 - 3) + 0.25f * float(i % 2), float(i % 3) - 1.1f)
                    .normalized();
            const auto found =
                texels_of(vectors.lobes, lobe_interpolation(vectors, exponent, direction), size);
            const std::vector<float> wanted = lobe_texels(exponent, direction, size);
            for (std::size_t t = 0; t < wanted.size(); ++t)
                ASSERT_NEAR(found[t], wanted[t], 0.008) << direction << ", texel " << t;
        }
}

TEST(LobeVectors, PruningKeepsTheErrorAndShortensThem) {
    const float exponent[] = {20};
    CoefficientSpectrum even;
    even.fill(2);
    const LobeShapes shapes = *lobe_shapes(exponent, 16, 0);
    const LobeVectors all = *lobe_vectors(shapes, even, 0), few = *lobe_vectors(shapes, even, 0.02f);
    EXPECT_LT(few.lobes.bytes() * 2, all.lobes.bytes());
    for (std::uint32_t row = 0; row < few.lobes.rows; row += 997) {
        double energy = 0, kept = 0;
        const auto energy_of = [&](const LobeVectors& vectors, double& sum) {
            vectors.lobes.block_of(row).for_each(row % SparseVectorBlocks::block_rows,
                                                 [&](std::uint32_t, float v) { sum += double(v) * v; });
        };
        energy_of(all, energy);
        energy_of(few, kept);
        EXPECT_GT(kept, energy * (1 - 0.0004 - 0.001)) << row;
        EXPECT_LT(kept, energy) << row;
    }
}

TEST(LobeVectors, StopWhenAsked) {
    std::stop_source stop;
    stop.request_stop();
    const float exponent[] = {20};
    const auto shapes = lobe_shapes(exponent, 16, 0, {{}, stop.get_token()});
    ASSERT_FALSE(shapes);
    EXPECT_EQ(shapes.error().code, ErrorCode::interrupted);
    const auto vectors = lobe_vectors(*lobe_shapes(exponent, 16, 0), {}, 0, {{}, stop.get_token()});
    ASSERT_FALSE(vectors);
    EXPECT_EQ(vectors.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace haarfield
