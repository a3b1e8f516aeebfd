#include "shading/walk/wide_visibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "fields/wavelets/haar_transform.h"
#include "shading/transfer/occlusion_vectors.h"
#include "tests/fixtures/unpacked_face.h"
#include "tests/oracles/pixel_reference.h"
#include "tests/oracles/wide_texels.h"

namespace haarfield {
namespace {

/// Truncated half planes, whose values leave [0, 1].
struct ExampleField {
    VisibilityField field;
    std::vector<std::vector<float>> exact;  ///< By cubemap, all faces.

    explicit ExampleField(std::uint32_t samples, int coefficients = 30) {
        PackedTrees packed;
        QuadtreePoolBuilder builder(64);
        for (std::uint32_t i = 0; i < samples; ++i) {
            std::vector<float> texels;
            for (std::uint32_t face = 0; face < cubemap_faces; ++face) {
                const auto half = face == 5 ? std::vector<float>(64 * 64, float(i % 2))
                                            : reference::half_plane_texels(10 * i + face, 64);
                texels.insert(texels.end(), half.begin(), half.end());
            }
            pack_trees(haar_cubemap<float>(texels, 64, {coefficients}), packed);
            const std::int32_t handle = builder.add(packed);
            exact.push_back(texels);
            (i % 3 == 0   ? field.local_handles
             : i % 3 == 1 ? field.planar_handles
                          : field.spherical_handles)
                .push_back(handle);
        }
        field.pool = std::move(builder).finish();
    }
};

TEST(WideVisibility, IsTheTruncatedVisibilityClampedToItsRange) {
    const ExampleField example(30);
    const VisibilityField& field = example.field;
    std::vector<std::uint32_t> order(field.local_handles.size());
    std::iota(order.rbegin(), order.rend(), 0u);
    const WideVisibility wide = *WideVisibility::make(field, order);
    const auto expect_cubemap = [&](const WideCubemap<std::uint8_t>& found, std::int32_t handle) {
        double error = 0, truncation_error = 0;
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            const auto texels = texels_of(found[face], 64);
            const auto truncated = quadtree_texels(
                unpacked_face(field.pool, field.pool.cubemaps[std::size_t(handle)][face]), 64);
            double mean = 0;
            for (std::size_t t = 0; t < texels.size(); ++t) {
                ASSERT_NEAR(texels[t], std::clamp(truncated[t], 0.0f, 1.0f), 0.5 / 255 + 1.0 / 512);
                const double exact = example.exact[std::size_t(handle)][face * texels.size() + t];
                error += std::pow(texels[t] - exact, 2);
                truncation_error += std::pow(truncated[t] - exact, 2);
                mean += texels[t] / double(texels.size());
            }
            EXPECT_NEAR(found[face].mean, mean, 0.5 / 255 + 1.0 / 512);
        }
        EXPECT_LT(error, truncation_error);
    };
    for (std::uint32_t i = 0; i < 10; ++i) {
        expect_cubemap(wide.local(i), field.local_handles[i]);
        expect_cubemap(wide.planar(i), field.planar_handles[i]);
        expect_cubemap(wide.spherical(i), field.spherical_handles[i]);
    }
}

TEST(WideVisibility, MeansOfVaryingCellsAreThoseOfTheirChildren) {
    const ExampleField example(3);
    const WideVisibility wide = *WideVisibility::make(example.field, std::vector<std::uint32_t>{0});
    int checked = 0;
    const auto check = [&](const auto& self, const WideNode<std::uint8_t>* node) -> void {
        for (unsigned cell = 0; cell < wide_cells; ++cell) {
            if (!(node->varying >> cell & 1u)) continue;
            const auto* child = child_of(node, cell);
            const double sum = std::accumulate(child->mean.begin(), child->mean.end(), 0.0);
            EXPECT_NEAR(node->mean[cell], sum / wide_cells, 1.0);
            ++checked;
            self(self, child);
        }
    };
    for (const auto& face : wide.local(0))
        if (face.root) check(check, face.root);
    EXPECT_GT(checked, 50);
}

TEST(WideVisibility, KeepsOpenAndBlockedFacesWithoutNodes) {
    const ExampleField example(6);
    const WideVisibility wide = *WideVisibility::make(example.field, std::vector<std::uint32_t>{0, 1});
    for (std::uint32_t i = 0; i < 2; ++i) {
        EXPECT_EQ(wide.local(i)[5].root, nullptr);
        EXPECT_EQ(wide.local(i)[5].mean, float(3 * i % 2));
    }
}

TEST(WideVisibility, StopsWhenAsked) {
    const ExampleField example(3);
    std::stop_source stop;
    stop.request_stop();
    const auto result = WideVisibility::make(example.field, std::vector<std::uint32_t>{0}, stop.get_token());
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::interrupted);
}

TEST(OcclusionVectors, AreTheCoefficientsOfTheOcclusionByTheSamples) {
    const ExampleField example(30);
    const VisibilityField& field = example.field;
    std::vector<std::uint32_t> order(field.local_handles.size());
    std::iota(order.begin(), order.end(), 0u);
    const WideVisibility wide = *WideVisibility::make(field, order);
    std::size_t before = ~std::size_t(0);
    for (const double error : {0.0, 0.01, 0.1}) {
        const SparseVectorBlocks vectors = *occlusion_vectors(field, wide, error);
        ASSERT_EQ(vectors.rows, field.planar_handles.size() + field.spherical_handles.size());
        for (std::size_t row = 0; row < vectors.rows; ++row) {
            const bool planar = row < field.planar_handles.size();
            const auto sample = static_cast<std::uint32_t>(planar ? row : row - field.planar_handles.size());
            std::vector<float> hidden;
            for (const auto& face : planar ? wide.planar(sample) : wide.spherical(sample))
                for (const double v : texels_of(face, 64)) hidden.push_back(static_cast<float>(1 - v));
            CoefficientSum wanted(64);
            wanted.add(haar_cubemap<float>(hidden, 64, {}), 1);
            double energy = 0, difference = 0;
            for (const std::uint32_t i : wanted.indices()) {
                energy += double(wanted[i]) * double(wanted[i]);
                difference += double(wanted[i]) * double(wanted[i]);
            }
            vectors.block_of(row).for_each(row, [&](std::uint32_t i, float v) {
                difference += std::pow(double(wanted[i]) - double(v), 2) - std::pow(double(wanted[i]), 2);
            });
            EXPECT_LE(difference, (error * error + 1e-5) * energy) << error << ", " << row;
        }
        EXPECT_LT(vectors.coefficients(), before);
        before = vectors.coefficients();
    }
    std::stop_source stop;
    stop.request_stop();
    EXPECT_FALSE(occlusion_vectors(field, wide, 0, {{}, stop.get_token()}));
}

}  // namespace
}  // namespace haarfield
