#include "shading/sparse_columns.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/pixel_reference.h"

namespace haarfield {
namespace {

constexpr std::size_t row_count = 300;

/// A function of few coefficients for even rows of ten, nothing for odd ones, a constant for the first.
CubemapTree function_of_row(std::uint32_t row, int size) {
    CubemapTree f;
    if (row == 0)
        for (Quadtree& face : f.faces) face.scaling = 100;
    if (row % 10 == 2)
        for (std::uint32_t face = 0; face < cubemap_faces; ++face)
            f.faces[face] =
                reference::random_quadtree(10 * row + face, std::countr_zero(unsigned(size)), 0.4);
    return f;
}

SparseVectors example_vectors(int size) {
    SparseVectors vectors(size, 1);
    CoefficientSum sum(size);
    for (std::uint32_t row = 0; row < row_count; ++row) {
        sum.clear();
        sum.add(function_of_row(row, size), 1);
        vectors.append(sum);
    }
    return vectors;
}

DenseCoefficients example_function(int size) {
    RgbCubemapTree f;
    for (std::uint32_t face = 0; face < cubemap_faces; ++face)
        f.faces[face] = reference::random_rgb_quadtree(7000 + face, std::countr_zero(unsigned(size)), 0.6);
    return dense_coefficients(f, size);
}

constexpr CoefficientSpectrum falling{1, 0.8f, 0.6f, 0.4f, 0.2f, 0.1f, 0.05f, 0.02f, 0.01f};

float weight_of(std::uint32_t index, int size) {
    return falling[spectrum_place(level_of_block(BlockNumbers(size), index / wide_cells),
                                  index % wide_cells)];
}

double energy_of(const std::array<float, 4>& value, float weight) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c) sum += std::pow(double(value[c]) * double(weight), 2);
    return sum;
}

TEST(SparseColumns, HoldTheRowsTransposed) {
    for (const int size : {16, 64, 128}) {
        const SparseVectors vectors = example_vectors(size);
        const SparseColumns columns(vectors);
        EXPECT_EQ(columns.scale, vectors.scale);
        EXPECT_EQ(columns.first.size(), coefficient_count(size) + 1);
        std::vector<std::vector<std::pair<std::uint32_t, float>>> found(row_count), wanted(row_count);
        std::pair<std::uint32_t, std::uint16_t> before{0, 0};
        columns.for_each([&](std::uint32_t index, std::uint16_t row, float value) {
            EXPECT_LE(before, std::pair(index, row));
            before = {index, row};
            found[row].emplace_back(index, value * columns.scale[row]);
        });
        for (std::size_t row = 0; row < row_count; ++row) {
            vectors.for_each(row, [&](std::uint32_t i, float v) { wanted[row].emplace_back(i, v); });
            std::sort(wanted[row].begin(), wanted[row].end());
        }
        EXPECT_EQ(found, wanted) << size;
    }
}

TEST(SparseColumns, InnerProductsAreIntegralsOverTheTexels) {
    for (const int size : {16, 64}) {
        const SparseColumns columns(example_vectors(size));
        const DenseCoefficients f = example_function(size);
        std::vector<std::array<float, 4>> sums(row_count, {1, 2, 3, 4});
        add_inner_products(columns, largest_coefficients(f, falling, 0), sums);
        for (std::uint32_t row = 0; row < row_count; ++row) {
            CoefficientSum of_row(size);
            of_row.add(function_of_row(row, size), 1);
            for (std::size_t c = 0; c < 3; ++c) {
                double wanted = 0, absolute = 0;
                for (const std::uint32_t index : of_row.indices()) {
                    const double term = double(of_row[index]) * double(f.values[index][c]);
                    wanted += term;
                    absolute += std::abs(term);
                }
                EXPECT_NEAR(double(sums[row][c] - float(c + 1)) * double(columns.scale[row]), wanted,
                            1e-3 * absolute + 1e-6 * double(columns.scale[row]))
                    << size << ", row " << row;
            }
            EXPECT_EQ(sums[row][3], 4);
        }
    }
}

TEST(LargestCoefficients, LeaveOutNoMoreThanTheErrorAndTheSmallest) {
    for (const int size : {16, 64, 128}) {
        const DenseCoefficients f = example_function(size);
        double all = 0;
        std::size_t nonzero = 0;
        for (std::uint32_t index = 0; index < f.values.size(); ++index) {
            const double energy = energy_of(f.values[index], weight_of(index, size));
            all += energy;
            nonzero += energy > 0;
        }
        EXPECT_EQ(largest_coefficients(f, falling, 0).index.size(), nonzero);
        for (const float error : {0.01f, 0.1f, 0.5f}) {
            const FewCoefficients few = largest_coefficients(f, falling, error);
            EXPECT_TRUE(std::is_sorted(few.index.begin(), few.index.end()));
            double kept = 0, smallest = all;
            std::vector<bool> is_kept(f.values.size(), false);
            for (std::size_t k = 0; k < few.index.size(); ++k) {
                EXPECT_EQ(few.value[k], f.values[few.index[k]]);
                const double energy = energy_of(few.value[k], weight_of(few.index[k], size));
                kept += energy;
                smallest = std::min(smallest, energy);
                is_kept[few.index[k]] = true;
            }
            EXPECT_LE(all - kept, double(error) * double(error) * all * (1 + 1e-9));
            EXPECT_GT(all - kept + smallest, double(error) * double(error) * all);
            for (std::uint32_t index = 0; index < f.values.size(); ++index)
                if (!is_kept[index]) {
                    EXPECT_LE(energy_of(f.values[index], weight_of(index, size)), smallest);
                }
        }
    }
}

}  // namespace
}  // namespace haarfield
