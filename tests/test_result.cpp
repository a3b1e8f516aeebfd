#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace haarfield {
namespace {

/// Returns `number`, or an error if it is negative. Counts its calls.
Result<std::unique_ptr<int>> checked(int number, int& calls) {
    ++calls;
    if (number < 0) return interruption("a");
    return std::make_unique<int>(number);
}

Result<int> sum(const std::vector<int>& numbers, int& calls) {
    int result = 0;
    for (const int number : numbers) {
        HF_TRY_DONE(checked(number, calls));
        HF_TRY(const std::unique_ptr<int> value, checked(number, calls));
        result += *value;
    }
    return result;
}

TEST(Result, TryGivesTheValueAndEvaluatesItsExpressionOnce) {
    int calls = 0;
    const Result<int> found = sum({3, 4}, calls);
    ASSERT_TRUE(bool(found));
    EXPECT_EQ(*found, 7);
    EXPECT_EQ(calls, 4);
}

TEST(Result, TryReturnsTheFirstErrorWithItsCode) {
    int calls = 0;
    const Result<int> found = sum({3, -1, 4}, calls);
    ASSERT_FALSE(bool(found));
    EXPECT_EQ(found.error().code, ErrorCode::interrupted);
    EXPECT_EQ(found.error().message(), "a: interrupted");
    EXPECT_EQ(calls, 3);
}

TEST(Result, TryAssignsToWhatExists) {
    int calls = 0;
    const auto assigned = [&](int number) -> Result<int> {
        std::vector<std::unique_ptr<int>> values(1);
        HF_TRY(values[0], checked(number, calls));
        return *values[0];
    };
    EXPECT_EQ(*assigned(5), 5);
    EXPECT_FALSE(bool(assigned(-5)));
}

}  // namespace
}  // namespace haarfield
