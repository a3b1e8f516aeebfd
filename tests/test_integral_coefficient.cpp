#include "tests/oracles/integral_coefficient.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace haarfield {
namespace {

using Kind = HaarBasisFunction::Kind;

/// Returns every scaling function and wavelet of levels 0 to `finest`.
std::vector<HaarBasisFunction> all_functions(int finest) {
    std::vector<HaarBasisFunction> functions;
    for (int level = 0; level <= finest; ++level)
        for (std::uint32_t y = 0; y < 1u << level; ++y)
            for (std::uint32_t x = 0; x < 1u << level; ++x)
                for (const Kind kind : {Kind::scaling, Kind::along_x, Kind::along_y, Kind::diagonal})
                    functions.push_back({kind, level, x, y});
    return functions;
}

/// Returns the function's values on pixels on which it is constant.
std::vector<double> pixels_of(const HaarBasisFunction& function, int size) {
    std::vector<double> pixels;
    const double side = 1.0 / (1 << function.level), amplitude = 1 << function.level;
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column) {
            // Position in the support, [0, 1) inside.
            const double x = ((column + 0.5) / size) / side - function.x;
            const double y = ((row + 0.5) / size) / side - function.y;
            double value = amplitude;
            if (x < 0 || x >= 1 || y < 0 || y >= 1) value = 0;
            if (function.kind == Kind::along_x || function.kind == Kind::diagonal) value *= x < 0.5 ? 1 : -1;
            if (function.kind == Kind::along_y || function.kind == Kind::diagonal) value *= y < 0.5 ? 1 : -1;
            pixels.push_back(value);
        }
    return pixels;
}

struct Comparison {
    std::vector<HaarBasisFunction> functions;
    std::vector<std::vector<double>> pixels;
    std::size_t compared = 0, non_zero = 0;

    explicit Comparison(int finest) : functions(all_functions(finest)) {
        for (const auto& function : functions) pixels.push_back(pixels_of(function, 2 << finest));
    }

    void expect_equal(const std::vector<std::size_t>& tuple) {
        double sum = 0;
        for (std::size_t pixel = 0; pixel < pixels[0].size(); ++pixel) {
            double value = 1;
            for (const std::size_t i : tuple) value *= pixels[i][pixel];
            sum += value;
        }
        const double expected = sum / double(pixels[0].size());
        std::vector<HaarBasisFunction> chosen;
        for (const std::size_t i : tuple) chosen.push_back(functions[i]);
        ++compared;
        non_zero += expected != 0;
        if (integral_coefficient(chosen) == expected) return;
        std::string names;
        for (const auto& f : chosen)
            names += " (kind " + std::to_string(int(f.kind)) + ", level " + std::to_string(f.level) + ", " +
                     std::to_string(f.x) + ", " + std::to_string(f.y) + ")";
        ADD_FAILURE() << integral_coefficient(chosen) << ", expected " << expected << " for" << names;
    }

    /// Tests all tuples of `count` functions, in one order each.
    void expect_all_equal(std::size_t count, std::vector<std::size_t>& tuple, std::size_t first = 0) {
        if (tuple.size() == count) return expect_equal(tuple);
        for (std::size_t i = first; i < functions.size() && !testing::Test::HasFailure(); ++i) {
            tuple.push_back(i);
            expect_all_equal(count, tuple, i);
            tuple.pop_back();
        }
    }
};

TEST(IntegralCoefficient, EqualsPixelSumForEveryTupleUpToFiveOnTwoLevels) {
    Comparison comparison(1);
    for (std::size_t count = 1; count <= 5; ++count) {
        std::vector<std::size_t> tuple;
        comparison.expect_all_equal(count, tuple);
    }
    EXPECT_EQ(comparison.compared, 20u + 210u + 1540u + 8855u + 42504u);
    EXPECT_GT(comparison.non_zero, 1000u);
}

TEST(IntegralCoefficient, EqualsPixelSumForEveryPairAndTripleOnThreeLevels) {
    Comparison comparison(2);
    for (std::size_t count = 2; count <= 3; ++count) {
        std::vector<std::size_t> tuple;
        comparison.expect_all_equal(count, tuple);
    }
    EXPECT_GT(comparison.non_zero, 1000u);
}

TEST(IntegralCoefficient, EqualsPixelSumForNestedTuplesInAnyOrderOnFourLevels) {
    // Random tuples are nearly always zero. These follow a path to a random square, so that many are not.
    Comparison comparison(3);
    std::mt19937 random(2006);
    for (int trial = 0; trial < 20000 && !HasFailure(); ++trial) {
        const std::uint32_t x = random() % 8, y = random() % 8;
        std::vector<std::size_t> tuple;
        for (std::size_t i = 0; i < 3 + random() % 3; ++i) {
            const int level = int(random() % 4), up = 3 - level;
            const std::size_t offset = 4 * (((std::size_t(1) << (2 * level)) - 1) / 3);
            tuple.push_back(offset + 4 * ((std::size_t(y >> up) << level) + (x >> up)) + random() % 4);
        }
        comparison.expect_equal(tuple);
    }
    EXPECT_GT(comparison.non_zero, 2000u);
}

TEST(IntegralCoefficient, OfPairsIsOrthonormality) {
    const std::vector<HaarBasisFunction> functions = all_functions(2);
    for (std::size_t i = 0; i < functions.size(); ++i)
        for (std::size_t j = 0; j < functions.size(); ++j) {
            const bool wavelets = functions[i].kind != Kind::scaling && functions[j].kind != Kind::scaling;
            if (!wavelets) continue;
            const HaarBasisFunction pair[] = {functions[i], functions[j]};
            EXPECT_EQ(integral_coefficient(pair), i == j ? 1 : 0) << i << ", " << j;
        }
}

}  // namespace
}  // namespace haarfield
