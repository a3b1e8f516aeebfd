#include "shading/transfer/grouped_columns.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "shading/transfer/group_pruning.h"
#include "tests/oracles/pixel_reference.h"

namespace haarfield {
namespace {

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

/// Entries of random groups, including the largest values and steps.
struct ExampleEntries {
    std::vector<std::uint32_t> indices;
    std::vector<GroupEntry> entries;
    std::vector<float> scales;

    ExampleEntries(int size, std::size_t groups) {
        std::mt19937 random(3);
        for (std::size_t group = 0; group < groups; ++group) {
            scales.push_back(0.5f + float(group));
            for (std::uint32_t index = random() % 7; index < coefficient_count(size);
                 index += 1 + random() % 40) {
                GroupEntry entry{
                    static_cast<std::uint8_t>(group), static_cast<std::uint8_t>(255 - random() % 60), {}};
                for (std::int8_t& value : entry.value)
                    value = static_cast<std::int8_t>(int(random() % 255) - 127);
                indices.push_back(index);
                entries.push_back(entry);
            }
        }
    }
};

TEST(GroupedColumns, HoldTheEntriesByIndex) {
    for (const int size : {16, 64, 128}) {
        const ExampleEntries example(size, 40);
        const GroupedColumns columns(size, example.indices, example.entries, example.scales);
        ASSERT_EQ(columns.first.size(), coefficient_count(size) + 1);
        EXPECT_EQ(columns.first.back(), example.entries.size());
        EXPECT_EQ(columns.scale, example.scales);
        std::vector<std::vector<GroupEntry>> wanted(coefficient_count(size));
        for (std::size_t i = 0; i < example.entries.size(); ++i)
            wanted[example.indices[i]].push_back(example.entries[i]);
        for (std::uint32_t index = 0; index < coefficient_count(size); ++index)
            ASSERT_EQ(std::vector<GroupEntry>(columns.entry.begin() + columns.first[index],
                                              columns.entry.begin() + columns.first[index + 1]),
                      wanted[index])
                << size << ", " << index;
    }
}

TEST(GroupedColumns, StepsHaveEightPlacesAnOctave) {
    EXPECT_EQ(entry_step(255), 1);
    EXPECT_EQ(entry_step(247), 0.5f);
    for (int exponent = 1; exponent < 256; ++exponent) {
        const float ratio = entry_step(static_cast<std::uint8_t>(exponent)) /
                            entry_step(static_cast<std::uint8_t>(exponent - 1));
        EXPECT_GT(ratio, 1);
        EXPECT_LE(ratio, 1.125f);
    }
}

TEST(GroupedColumns, InnerProductsAreSumsOverTheEntries) {
    for (const int size : {16, 64}) {
        constexpr std::size_t groups = GroupedColumns::most_groups;
        const ExampleEntries example(size, groups);
        const GroupedColumns columns(size, example.indices, example.entries, example.scales);
        const DenseCoefficients f = example_function(size);
        std::vector<GroupSums> sums(groups);
        for (GroupSums& sum : sums)
            for (std::size_t c = 0; c < 3; ++c) sum[c].fill(float(c));
        add_inner_products(columns, largest_coefficients(f, falling, 0), sums);
        std::vector<std::array<std::array<double, group_rows>, 3>> wanted(groups), absolute(groups);
        for (std::size_t i = 0; i < example.entries.size(); ++i)
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t k = 0; k < group_rows; ++k) {
                    const GroupEntry& entry = example.entries[i];
                    const double term = double(entry.value[k]) * double(entry_step(entry.exponent)) *
                                        double(f.values[example.indices[i]][c]);
                    wanted[entry.group][c][k] += term;
                    absolute[entry.group][c][k] += std::abs(term);
                }
        for (std::size_t group = 0; group < groups; ++group)
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t k = 0; k < group_rows; ++k)
                    ASSERT_NEAR(sums[group][c][k], double(c) + wanted[group][c][k],
                                1e-6 * (1 + absolute[group][c][k]))
                        << size << ", group " << group;
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
            const SelectedCoefficients few = largest_coefficients(f, falling, error);
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

/// Returns products of two channels for some of a group's rows. The last row has a block that no other has.
std::vector<WaveletBlock<2>> example_product(std::size_t row, int size) {
    const BlockNumbers numbers(size);
    std::mt19937 random(static_cast<unsigned>(row));
    std::vector<WaveletBlock<2>> product;
    for (std::uint32_t block = 0; block < numbers.count(); ++block) {
        if (block % 3 == 1 && block != 4 * row + 7) continue;
        WaveletBlock<2>& added = product.emplace_back();
        added.block = block;
        added.level = static_cast<std::uint16_t>(level_of_block(numbers, block));
        for (std::size_t c = 0; c < 2; ++c)
            for (float& a : added.amplitude[c])
                a = std::ldexp(float(int(random() % 2001) - 1000), -8 - int(c)) *
                    std::ldexp(1.0f, -int(random() % 12));
    }
    return product;
}

class GroupPruningTest : public testing::TestWithParam<int> {
protected:
    using Values = std::map<std::uint32_t, std::array<float, group_rows>>;  ///< Indexed by entry.

    /// True for rows with products.
    static bool is_there(std::size_t row) { return row != 1 && row != 6; }
    static std::array<float, 2> weights_of(std::size_t row) { return {0.5f + float(row), 2}; }

    void take_rows(GroupPruning<2>& pruning) const {
        for (std::size_t row = 0; row < group_rows; ++row) {
            if (!is_there(row)) continue;
            pruning.product(row) = example_product(row, size);
            pruning.set_weights(row, weights_of(row));
        }
    }

    /// Returns the values that a channel's entries represent.
    static Values values(std::size_t channel, const std::vector<std::uint32_t>& indices,
                         const std::vector<GroupEntry>& entries, const std::vector<float>& scales,
                         std::size_t first_group) {
        Values result;
        for (std::size_t i = 0; i < entries.size(); ++i) {
            if (entries[i].group != first_group + channel) continue;
            for (std::size_t k = 0; k < group_rows; ++k)
                result[indices[i]][k] =
                    entries[i].value[k] * entry_step(entries[i].exponent) * scales[first_group + channel];
        }
        return result;
    }

    Values wanted_values(std::size_t channel) const {
        Values result;
        const BlockNumbers numbers(size);
        for (std::size_t row = 0; row < group_rows; ++row)
            if (is_there(row))
                for (const WaveletBlock<2>& block : example_product(row, size))
                    for (std::uint32_t slot = 0; slot < wide_cells; ++slot) {
                        const float value =
                            block.amplitude[channel][slot] *
                            coefficient_of_amplitude(level_of_block(numbers, block.block), slot);
                        if (value != 0) result[16 * block.block + slot][row] = value;
                    }
        return result;
    }

    const int size = GetParam();
};
INSTANTIATE_TEST_SUITE_P(Sizes, GroupPruningTest, testing::Values(8, 32, 64));

TEST_P(GroupPruningTest, UnprunedGroupsAreTheProductsToAQuarterOfAPercentOfTheGroupsLargest) {
    GroupPruning<2> pruning(size, falling);
    for (int turn = 0; turn < 2; ++turn) {  // the second one reuses the memory of the first
        std::vector<std::uint32_t> indices;
        std::vector<GroupEntry> entries;
        std::vector<float> scales(3, 0.0f);
        pruning.clear();
        take_rows(pruning);
        pruning.append(0, 3, indices, entries, scales);
        ASSERT_EQ(scales.size(), 5u);
        for (std::size_t channel = 0; channel < 2; ++channel) {
            const Values found = values(channel, indices, entries, scales, 3),
                         wanted = wanted_values(channel);
            ASSERT_EQ(found.size(), wanted.size());
            for (const auto& [index, of_rows] : wanted) {
                float largest = 0;
                for (const float value : of_rows) largest = std::max(largest, std::abs(value));
                for (std::size_t k = 0; k < group_rows; ++k)
                    ASSERT_NEAR(found.at(index)[k], of_rows[k], largest * 1.126f / 254) << index;
            }
        }
    }
}

TEST_P(GroupPruningTest, DropsTheSmallestUpToTheErrorOverAllRowsAndChannels) {
    GroupPruning<2> pruning(size, falling);
    std::array<Values, 2> wanted{wanted_values(0), wanted_values(1)};
    const auto energy = [&](std::size_t channel, std::uint32_t index) {
        double sum = 0;
        for (std::size_t k = 0; k < group_rows; ++k)
            sum += double(weights_of(k)[channel]) *
                   std::pow(double(wanted[channel][index][k]) * double(weight_of(index, size)), 2);
        return sum;
    };
    double all = 0;
    for (std::size_t channel = 0; channel < 2; ++channel)
        for (const auto& [index, of_rows] : wanted[channel]) all += energy(channel, index);
    for (const double error : {0.003, 0.03, 0.3}) {
        std::vector<std::uint32_t> indices;
        std::vector<GroupEntry> entries;
        std::vector<float> scales;
        pruning.clear();
        take_rows(pruning);
        pruning.append(error, 0, indices, entries, scales);
        double dropped = all, smallest = all, largest_dropped = 0;
        std::set<std::pair<std::size_t, std::uint32_t>> kept;
        for (std::size_t i = 0; i < entries.size(); ++i) {
            const double of_entry = energy(entries[i].group, indices[i]);
            dropped -= of_entry;
            smallest = std::min(smallest, of_entry);
            kept.emplace(entries[i].group, indices[i]);
        }
        for (std::size_t channel = 0; channel < 2; ++channel)
            for (const auto& [index, of_rows] : wanted[channel])
                if (!kept.count({channel, index}))
                    largest_dropped = std::max(largest_dropped, energy(channel, index));
        EXPECT_LE(dropped, error * error * all * 1.001 + 1e-6 * all) << error;
        EXPECT_GE(dropped, 0.5 * error * error * all - 1e-6 * all) << error;
        EXPECT_LE(largest_dropped, smallest * 1.0001) << error;
    }
}

TEST_P(GroupPruningTest, OfNothingIsEmpty) {
    GroupPruning<3> pruning(size, falling);
    std::vector<std::uint32_t> indices;
    std::vector<GroupEntry> entries;
    std::vector<float> scales;
    pruning.append(0.01, 0, indices, entries, scales);
    EXPECT_TRUE(indices.empty() && entries.empty());
    EXPECT_EQ(scales, std::vector<float>(3, 0.0f));
}

}  // namespace
}  // namespace haarfield
