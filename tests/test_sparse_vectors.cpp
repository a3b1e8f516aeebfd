#include "shading/transfer/sparse_vectors.h"

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <map>
#include <random>

#include "fields/wavelets/haar_transform.h"
#include "shading/transfer/product_pruning.h"
#include "shading/transfer/sparse_products.h"
#include "shading/walk/product_integral.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

CubemapTree random_cubemap(std::uint32_t seed, int size, double density = 0.6) {
    CubemapTree cubemap;
    for (std::uint32_t face = 0; face < cubemap_faces; ++face)
        cubemap.faces[face] =
            reference::random_quadtree(10 * seed + face, std::countr_zero(unsigned(size)), density);
    return cubemap;
}

RgbCubemapTree random_rgb_cubemap(std::uint32_t seed, int size) {
    RgbCubemapTree cubemap;
    for (std::uint32_t face = 0; face < cubemap_faces; ++face)
        cubemap.faces[face] =
            reference::random_rgb_quadtree(10 * seed + face, std::countr_zero(unsigned(size)), 0.6);
    return cubemap;
}

/// The integral of the product over the unit squares of the faces, by texels, and that of its absolute
/// values.
struct PixelIntegral {
    double value = 0, absolute = 0;
};
PixelIntegral pixel_integral(const CubemapTree& f, const CubemapTree& g, int size) {
    PixelIntegral sum;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const auto product = reference::product(std::vector<reference::Texels>{
            reference::texels_of(f.faces[face], size), reference::texels_of(g.faces[face], size)});
        sum.value += reference::mean(product);
        sum.absolute += reference::absolute_mean(product);
    }
    return sum;
}

CubemapTree channel_of(const RgbCubemapTree& f, int channel) {
    CubemapTree result;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const RgbQuadtree& from = f.faces[face];
        result.faces[face].scaling = from.scaling[channel];
        for (const auto& node : from.nodes)
            result.faces[face].nodes.push_back(
                {{node.wavelet[0][channel], node.wavelet[1][channel], node.wavelet[2][channel]},
                 node.children});
    }
    return result;
}

using Coefficients = std::map<std::uint32_t, std::array<float, 3>>;

/// Returns the non-zero coefficients of three channels.
Coefficients coefficients(const RgbCubemapTree& f, int size) {
    Coefficients result;
    const DenseCoefficients dense = dense_coefficients(f, size);
    for (std::uint32_t index = 0; index < dense.values.size(); ++index) {
        const auto& [red, green, blue, unused] = dense.values[index];
        if (red != 0 || green != 0 || blue != 0) result[index] = {red, green, blue};
    }
    return result;
}

void append(const RgbCubemapTree& f, SparseVectors& to) {
    std::vector<std::uint32_t> indices;
    std::vector<float> values;
    for (const auto& [index, value] : coefficients(f, to.face_size)) {
        indices.push_back(index);
        values.insert(values.end(), value.begin(), value.end());
    }
    to.append(indices, values);
}

/// Returns a row of three channels.
Coefficients row_of(const SparseVectors& vectors, std::size_t row) {
    Coefficients result;
    for (std::size_t i = vectors.first[row * vectors.pages()]; i < vectors.first[(row + 1) * vectors.pages()];
         ++i)
        for (std::size_t c = 0; c < 3; ++c)
            result[vectors.index[i]][c] = half_value(vectors.value[3 * i + c]) * vectors.scale[row];
    return result;
}

TEST(CoefficientSum, SumsOfProductsAreIntegralsOverTheTexels) {
    for (const int size : {2, 4, 8, 32, 64, 128}) {
        const CubemapTree f = random_cubemap(1, size), g = random_cubemap(2, size);
        CoefficientSum f_sum(size), g_sum(size);
        f_sum.add(f, 2);
        g_sum.add(g, 1);
        double sum = 0;
        for (const std::uint32_t index : f_sum.indices()) {
            EXPECT_LT(index, coefficient_count(size));
            sum += double(f_sum[index]) * double(g_sum[index]);
        }
        const PixelIntegral wanted = pixel_integral(f, g, size);
        EXPECT_NEAR(sum, 2 * wanted.value, 2e-6 * wanted.absolute) << size;
    }
}

TEST(CoefficientSum, ClearForgetsEverything) {
    CoefficientSum sum(16);
    sum.add(random_cubemap(1, 16), 1);
    const std::uint32_t some = sum.indices()[5];
    sum.clear();
    EXPECT_TRUE(sum.indices().empty());
    EXPECT_EQ(sum[some], 0);
    sum.add(17, 2);
    EXPECT_EQ(sum.indices().size(), 1u);
    EXPECT_EQ(sum[17], 2);
}

/// Returns lighting times a half plane, as a product.
std::vector<WaveletBlock<3>> example_product(std::uint32_t seed, int size) {
    const LightPyramid light(random_rgb_cubemap(seed, size), size);
    const CubemapTree other = random_cubemap(seed + 100, size);
    const WideCubemapTree wide(other);
    const WeightedTrees<float>::Part part{&wide.faces(), 1};
    const WeightedTrees<float> factor{0, std::span(&part, 1)};
    WalkMemory<float> memory;
    std::vector<WaveletBlock<3>> product;
    function_product(light, std::span(&factor, 1), full_depth, memory, product);
    return product;
}

CoefficientSpectrum example_spectrum() {
    CoefficientSpectrum spectrum;
    for (std::size_t place = 0; place < spectrum.size(); ++place) spectrum[place] = 1 / float(1 + place);
    return spectrum;
}

/// Returns the sum of energies over the coefficients, weighted by example_spectrum.
double weighted_energy(const Coefficients& coefficients, int size) {
    const BlockNumbers numbers(size);
    double sum = 0;
    for (const auto& [index, value] : coefficients) {
        const double weight =
            1.0 / (1.0 + double(spectrum_place(level_of_block(numbers, index / 16), index % 16)));
        for (const float v : value) sum += double(v) * double(v) * weight * weight;
    }
    return sum;
}

TEST(ProductPruning, UnprunedRowsAreTheProduct) {
    for (const int size : {8, 32, 64}) {
        // Lighting only, so that the coefficients are known.
        const RgbCubemapTree light = random_rgb_cubemap(3, size);
        WalkMemory<float> memory;
        std::vector<WaveletBlock<3>> product;
        function_product(LightPyramid(light, size), {}, full_depth, memory, product);
        ProductPruning pruning(size, example_spectrum());
        SparseVectors rgb(size, 3);
        pruning.take(product);
        pruning.append(0, rgb);
        const Coefficients wanted = coefficients(light, size), found = row_of(rgb, 0);
        for (const auto& [index, value] : wanted)
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(found.count(index) ? found.at(index)[c] : 0, value[c],
                            1e-3 * std::abs(value[c]) + 1e-6 * rgb.scale[0]);
        Rgb means(0.0f);
        for (const RgbQuadtree& face : light.faces) means += face.scaling;
        EXPECT_LT((pruning.integral() - means).length(), 1e-5 * means.length());
        EXPECT_NEAR(pruning.energy(), weighted_energy(wanted, size), 1e-4 * weighted_energy(wanted, size));
    }
}

TEST(ProductPruning, DropsTheSmallestUpToTheAllowedEnergy) {
    const int size = 64;
    ProductPruning pruning(size, example_spectrum());
    for (std::uint32_t seed = 0; seed < 5; ++seed) {
        const auto product = example_product(seed, size);
        pruning.take(product);
        SparseVectors all(size, 3);
        pruning.append(0, all);
        const Coefficients before = row_of(all, 0);
        const double energy = weighted_energy(before, size);
        for (const double share : {1e-6, 1e-4, 1e-2, 0.1}) {
            SparseVectors vectors(size, 3);
            pruning.append(share * energy, vectors);
            const Coefficients after = row_of(vectors, 0);
            const double dropped = energy - weighted_energy(after, size);
            EXPECT_LT(dropped, share * energy * 1.001 + 1e-6 * energy) << share;
            EXPECT_LT(after.size(), before.size());
            for (const auto& [index, value] : after) EXPECT_TRUE(before.count(index));
            if (share > 1e-5) {
                EXPECT_GT(dropped, 0.7 * share * energy) << share;
            }
        }
        SparseVectors nothing(size, 3);
        pruning.append(1e30, nothing);
        EXPECT_EQ(nothing.index.size(), 0u);
    }
}

TEST(ProductPruning, OfNothingIsEmpty) {
    ProductPruning pruning(16, example_spectrum());
    pruning.take({});
    SparseVectors vectors(16, 3);
    pruning.append(0, vectors);
    EXPECT_EQ(vectors.rows(), 1u);
    EXPECT_EQ(vectors.scale[0], 0);
    EXPECT_EQ(pruning.energy(), 0);
    EXPECT_EQ(pruning.integral(), Rgb(0.0f));
}

TEST(SparseVectors, StoreCoefficientsInHalfPrecision) {
    for (const int size : {16, 64, 128}) {  // for 128: two pages
        SparseVectors vectors(size, 1);
        CoefficientSum sum(size);
        for (std::uint32_t row = 0; row < 5; ++row) {
            sum.clear();
            sum.add(random_cubemap(row, size), std::pow(10.0f, 3.0f * float(row)));
            row == 3 ? vectors.append_empty() : vectors.append(sum);
        }
        ASSERT_EQ(vectors.rows(), 5u);
        for (std::uint32_t row = 0; row < 5; ++row) {
            sum.clear();
            if (row != 3) sum.add(random_cubemap(row, size), std::pow(10.0f, 3.0f * float(row)));
            std::size_t count = 0;
            vectors.for_each(row, [&](std::uint32_t index, float value) {
                EXPECT_NEAR(value, sum[index], std::abs(sum[index]) / 2000 + vectors.scale[row] / 3e7);
                ++count;
            });
            EXPECT_EQ(count, sum.indices().size());
        }
    }
}

TEST(SparseVectors, ValuesAreTheNearestHalfFloats) {
    std::vector<std::uint32_t> indices;
    std::vector<float> values;
    std::mt19937 random(2006);
    for (std::uint32_t i = 0; i < 4000; ++i) {
        const float magnitude = std::ldexp(1 + float(random() % 8192) / 8192, -1 - int(i % 28));
        indices.push_back(i);
        values.push_back(i % 2 == 0 ? magnitude : -magnitude);
    }
    values[0] = 1;  // the scale
    SparseVectors vectors(64, 1);
    vectors.append(indices, values);
    std::size_t next = 0;
    vectors.for_each(0, [&](std::uint32_t, float value) {
        EXPECT_EQ(value, float(Imath::half(values[next]))) << values[next];
        ++next;
    });
    EXPECT_EQ(next, values.size());
}

TEST(SparseVectors, InterpolatedInnerProductsAreWeightedSumsOfIntegrals) {
    for (const int size : {16, 128}) {
        // More functions than there are columns, in turns that keep some of them and replace others.
        constexpr std::uint32_t function_count = 40, row_count = 300;
        SparseVectorBlocks functions(function_count, size, 1), vectors(row_count, size, 3);
        CoefficientSum sum(size);
        for (std::uint32_t f = 0; f < function_count; ++f) {
            sum.clear();
            sum.add(random_cubemap(f, size, 0.3), 1);
            functions.blocks[0].append(sum);
        }
        const auto rgb_of = [&](std::uint32_t row) { return random_rgb_cubemap(row % 3, size); };
        std::vector<Interpolation> at(row_count);
        for (std::uint32_t row = 0; row < row_count; ++row) {
            append(rgb_of(row), vectors.blocks[row / 256]);
            at[row].count = static_cast<int>(row % 9);
            for (std::uint32_t k = 0; k < row % 9; ++k) {
                at[row].sample[k] = (row / 5 + 7 * k * (row % 2 + 1)) % function_count;
                at[row].weight[k] = 0.1f * float(k + 1);
            }
        }
        at[14].sample[1] = at[14].sample[0];  // the same one twice
        for (const std::size_t row : {25, 61, 116}) at[row] = at[row - 1];
        at[117] = at[116];  // all but one of them
        at[117].sample[6] = 1;
        constexpr float before = 0.25f;
        std::vector<Rgb> found(row_count, Rgb(before));
        const RowInterpolations rows = found_interpolations(row_count, {}, [&](std::size_t row) {
            return RowInterpolation{std::uint32_t(row), at[row]};
        });
        ASSERT_TRUE(add_interpolated_products(vectors, functions, rows, found));
        for (std::uint32_t row = 0; row < row_count; row += size == 16 ? 1 : 37)
            for (int channel = 0; channel < 3; ++channel) {
                double wanted = 0, absolute = 0;
                for (int k = 0; k < at[row].count; ++k) {
                    const PixelIntegral integral =
                        pixel_integral(channel_of(rgb_of(row), channel),
                                       random_cubemap(at[row].sample[std::size_t(k)], size, 0.3), size);
                    wanted += double(at[row].weight[std::size_t(k)]) * integral.value;
                    absolute += double(at[row].weight[std::size_t(k)]) * integral.absolute;
                }
                EXPECT_NEAR(found[row][channel] - before, wanted, 1e-3 * absolute + 1e-7) << row;
            }
    }
}

TEST(SparseVectors, SpectraAreTheRootMeanSquaresOfTheLevels) {
    const RgbCubemapTree f = random_rgb_cubemap(5, 32);
    const CoefficientSpectrum found = rms_spectrum(dense_coefficients(f, 32));
    double energy = 0, squares = 0;
    for (std::size_t place = 0; place < found.size(); ++place)
        energy += double(found[place]) * found[place] * cubemap_faces *
                  (place == 0 ? 1 : 3 * std::pow(4.0, double(place) - 1)) * (place <= 5 ? 1 : 0);
    for (int channel = 0; channel < 3; ++channel) {
        const CubemapTree one = channel_of(f, channel);
        squares += pixel_integral(one, one, 32).value / 3;
    }
    EXPECT_NEAR(energy, squares, 1e-5 * squares);
    // The mean has a separate index.
    CubemapTree constant;
    for (Quadtree& face : constant.faces) face.scaling = 3;
    SparseVectorBlocks one(1, 16, 1);
    CoefficientSum sum(16);
    sum.add(constant, 1);
    one.blocks[0].append(sum);
    EXPECT_EQ(rms_spectrum(one), (CoefficientSpectrum{3, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(DenseCoefficients, WeightedSumIsLinear) {
    const DenseCoefficients a = dense_coefficients(random_rgb_cubemap(1, 16), 16),
                            b = dense_coefficients(random_rgb_cubemap(2, 16), 16);
    const DenseCoefficients* const both[] = {&a, &b};
    const float weights[] = {0.25f, 2};
    const DenseCoefficients sum = weighted_sum(both, weights);
    for (std::size_t i = 0; i < sum.values.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_FLOAT_EQ(sum.values[i][c], 0.25f * a.values[i][c] + 2 * b.values[i][c]);
}

}  // namespace
}  // namespace haarfield
