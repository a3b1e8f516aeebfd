#include "tools/number_option.h"

#include <gtest/gtest.h>

namespace haarfield {
namespace {

TEST(NumberOption, TakesDecimalNumbersOfTheRange) {
    const Range range{-2, 10};
    EXPECT_EQ(number_in(range, "10"), 10.0);
    EXPECT_EQ(number_in(range, "-2"), -2.0);
    EXPECT_EQ(number_in(range, "0.25"), 0.25);
    EXPECT_EQ(number_in(range, "1e-1"), 0.1);
    EXPECT_EQ(number_in(range, "7", true), 7.0);
    EXPECT_EQ(number_in(range, "10.0001"), std::nullopt);
    EXPECT_EQ(number_in(range, "-2.0001"), std::nullopt);
}

TEST(NumberOption, RefusesAllOtherTexts) {
    const Range range{-1e300, 1e300};
    for (const char* text : {"",      "-",      "+",  ".",  "e",  "nan",  "NaN", "inf", "-inf", "infinity",
                             "1e999", "-1e999", "1x", "1 ", " 1", "0x10", "1,5", "1e",  "--1",  "1\n"})
        EXPECT_EQ(number_in(range, text), std::nullopt) << text;
    for (const char* text : {"1.0", "1e2", "1.", ".5"})
        EXPECT_EQ(number_in(range, text, true), std::nullopt) << text;
}

TEST(NumberOption, APlaceHasThreeCoordinates) {
    EXPECT_EQ(place_in("1,-2,0.5"), Vec3f(1, -2, 0.5f));
    for (const char* text : {"", "1,2", "1,2,3,4", "1,2,", ",,", "1,2,nan", "1;2;3", "1, 2, x"})
        EXPECT_EQ(place_in(text), std::nullopt) << text;
}

}  // namespace
}  // namespace haarfield
