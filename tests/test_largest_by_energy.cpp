#include "fields/wavelets/largest_by_energy.h"

#include <gtest/gtest.h>

#include <functional>
#include <numeric>
#include <random>
#include <vector>

namespace haarfield {
namespace {

TEST(LargestByEnergy, IsTheFewestOfTheLargest) {
    std::mt19937 random(7);
    for (int round = 0; round < 200; ++round) {
        // Integers, so that sums are exact in any order; with ties.
        std::vector<int> items(std::size_t(1 + round));
        for (int& item : items) item = int(random() % 50);
        const int sum = std::accumulate(items.begin(), items.end(), 0);
        const double allowed = double(random() % unsigned(sum + 2));
        std::vector<int> sorted = items;
        std::sort(sorted.begin(), sorted.end(), std::greater<>());
        std::size_t wanted = sorted.size();
        for (double left = allowed; wanted > 0 && sorted[wanted - 1] <= left; --wanted)
            left -= sorted[wanted - 1];

        const std::size_t kept = largest_by_energy(
            std::span(items), allowed, [](int item) { return double(item); }, std::greater<>());
        EXPECT_EQ(kept, wanted);
        std::sort(items.begin(), items.begin() + std::ptrdiff_t(kept), std::greater<>());
        for (std::size_t i = 0; i < kept; ++i) EXPECT_EQ(items[i], sorted[i]);
    }
}

TEST(LargestByEnergy, OfNothingIsNothing) {
    std::vector<double> none;
    EXPECT_EQ(largest_by_energy(
                  std::span(none), 1.0, [](double item) { return item; }, std::greater<>()),
              0u);
}

}  // namespace
}  // namespace haarfield
