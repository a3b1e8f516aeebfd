#include "fields/base/range.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace haarfield {
namespace {

TEST(Range, HoldsItsEndsUnlessTheyAreLeftOut) {
    for (const bool without_lowest : {false, true})
        for (const bool without_highest : {false, true}) {
            const Range range{-0.5, 2, without_lowest, without_highest};
            EXPECT_EQ(range.contains(-0.5), !without_lowest);
            EXPECT_EQ(range.contains(2), !without_highest);
            EXPECT_TRUE(range.contains(-0.499) && range.contains(1.999));
            EXPECT_FALSE(range.contains(-0.501) || range.contains(2.001));
        }
}

TEST(Range, HoldsNothingThatIsNotFinite) {
    for (const Range& range : {Range{-1, 1}, Range{-1, std::numeric_limits<double>::infinity()}}) {
        EXPECT_TRUE(range.contains(1));
        EXPECT_FALSE(range.contains(std::nan("")));
        EXPECT_FALSE(range.contains(std::numeric_limits<double>::infinity()));
        EXPECT_FALSE(range.contains(-std::numeric_limits<double>::infinity()));
    }
}

TEST(Range, ContainsOnlyNumbersThatAreInItAsFloats) {
    EXPECT_TRUE((Range{1e-4, 1}.contains(1e-4)));  // rounds down to float
    EXPECT_FALSE((Range{0, 1, false, true}.contains(1 - 1e-12)));
    EXPECT_FALSE((Range{1, 2, true, false}.contains(1 + 1e-12)));
}

TEST(Range, IsWrittenAsAnInterval) {
    EXPECT_EQ((Range{0, 1, true, false}.text()), "(0, 1]");
    EXPECT_EQ((Range{0.5, 1e6, false, true}.text()), "[0.5, 1000000)");
}

}  // namespace
}  // namespace haarfield
