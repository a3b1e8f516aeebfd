#include "fields/base/random_choice.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>

namespace haarfield {
namespace {

std::vector<int> chosen(int count, std::size_t wanted) {
    std::vector<int> items(std::size_t(count), 0);
    std::iota(items.begin(), items.end(), 0);
    keep_random(items, wanted);
    return items;
}

// Computed independently of <random> and this library, from the definition of the Mersenne Twister.
TEST(RandomChoice, IsTheOneThatItsSourceDefines) {
    EXPECT_EQ(chosen(10, 10), (std::vector<int>{2, 9, 1, 5, 7, 6, 4, 8, 0, 3}));
    EXPECT_EQ(chosen(100000, 5), (std::vector<int>{24155, 95058, 97175, 33710, 63427}));
}

TEST(RandomChoice, KeepsSomeOfTheItemsAndEachOnce) {
    for (const int count : {0, 1, 2, 50})
        for (const std::size_t wanted : {std::size_t(0), std::size_t(1), std::size_t(20), std::size_t(80)}) {
            const std::vector<int> items = chosen(count, wanted);
            EXPECT_EQ(items.size(), std::min(std::size_t(count), wanted));
            std::vector<bool> seen(std::size_t(count), false);
            for (const int item : items) {
                ASSERT_TRUE(item >= 0 && item < count) << item;
                EXPECT_FALSE(seen[std::size_t(item)]) << item << " twice, of " << count;
                seen[std::size_t(item)] = true;
            }
        }
}

/// 2,000 of 20,000 items: each tenth has its fraction, within five standard deviations.
TEST(RandomChoice, TakesFromEverywhere) {
    std::array<int, 10> count{};
    for (const int item : chosen(20000, 2000)) ++count[std::size_t(item / 2000)];
    for (const int in_tenth : count) EXPECT_NEAR(in_tenth, 200, 5 * 13);
}

}  // namespace
}  // namespace haarfield
