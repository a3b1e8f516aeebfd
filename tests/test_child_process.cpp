#include "fields/file/child_process.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

#ifdef __linux__
#include "fields/file/linux/process_status.h"
#endif

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

#ifdef __linux__
TEST(ProcessStatus, OfAProcessThatEndsIsNotAnError) {
    for (int round = 0; round < 300; ++round) {
        const pid_t process = fork();
        if (process == 0) _exit(0);
        std::atomic<bool> has_ended = false;
        std::thread reader([&] {
            while (!has_ended) (void)process_status(process);
        });
        waitpid(process, nullptr, 0);
        has_ended = true;
        reader.join();
        EXPECT_TRUE(process_status(process).empty());
    }
}
#endif

TEST(ChildProcess, WithoutAChildThereIsNoProcessorTime) {
    EXPECT_FALSE(ChildProcess().processor_seconds());
}

}  // namespace
}  // namespace haarfield
