#include "fields/file/child_process.h"

#include <gtest/gtest.h>

#include <chrono>

namespace haarfield {
namespace {

/// Runs a shell in a shell, and returns its processor time when it has written a line.
double seconds_of(const std::string& work) {
    ChildProcess child;
    EXPECT_EQ(child.start("sh", {"-c", "sh -c '" + work + "; echo done >&2; sleep 5'"}, "/"), 0);
    std::string log;
    while (log.find('\n') == std::string::npos && child.read_some(log)) {
    }
    const std::optional<double> seconds = child.processor_seconds();
    EXPECT_TRUE(seconds);
    return seconds.value_or(-1);
}

TEST(ChildProcess, CountsProcessorTimeOfDescendantsAndNotTheirSleep) {
    EXPECT_LT(seconds_of("sleep 0.5"), 0.3);
    EXPECT_GT(seconds_of("i=0; while [ $i -lt 400000 ]; do i=$((i+1)); done"), 0.05);
}

TEST(ChildProcess, WithoutAChildThereIsNoProcessorTime) {
    EXPECT_FALSE(ChildProcess().processor_seconds());
}

}  // namespace
}  // namespace haarfield
