#include "fields/base/parallel_loop.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <set>
#include <thread>
#include <vector>

#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

TEST(ParallelLoop, DoesEveryItemOnce) {
    for (const std::size_t count :
         {std::size_t(0), std::size_t(1), std::size_t(63), std::size_t(64), std::size_t(1000)})
        for (const std::size_t together :
             {std::size_t(1), std::size_t(7), std::size_t(64), std::size_t(5000)}) {
            std::vector<int> times(count);
            EXPECT_TRUE(parallel_loop({count, together},
                                      [&]() -> LoopBody { return [&](std::size_t i) { ++times[i]; }; },
                                      "counting", {}));
            EXPECT_EQ(times, std::vector<int>(count, 1)) << count << ' ' << together;
        }
}

TEST(ParallelLoop, GivesNeighboursToOneThreadInTheirOrder) {
    constexpr std::size_t count = 640, together = 16;
    std::vector<std::thread::id> by(count);
    std::vector<std::size_t> turn(count);
    std::atomic<std::size_t> turns = 0;
    EXPECT_TRUE(parallel_loop({count, together},
                              [&]() -> LoopBody {
                                  return [&](std::size_t i) {
                                      by[i] = std::this_thread::get_id();
                                      turn[i] = turns++;
                                  };
                              },
                              "counting", {}));
    for (std::size_t i = 1; i < count; ++i)
        if (i % together != 0) {
            EXPECT_EQ(by[i], by[i - 1]) << i;
            EXPECT_GT(turn[i], turn[i - 1]) << i;
        }
}

TEST(ParallelLoop, NoTwoThreadsShareABody) {
    std::atomic<bool> shared = false;
    EXPECT_TRUE(parallel_loop({2000, 4},
                              [&]() -> LoopBody {
                                  return
                                      [&, own = std::make_shared<std::set<std::thread::id>>()](std::size_t) {
                                          own->insert(std::this_thread::get_id());
                                          if (own->size() != 1) shared = true;
                                      };
                              },
                              "counting", {}));
    EXPECT_FALSE(shared);
}

TEST(ParallelLoop, EntersNoBodyOrReportAgainWhileItWaitsForNestedLoops) {
    std::atomic<int> entered_again = 0;
    std::atomic<std::size_t> sum = 0;
    const auto nested_loop = [&] {
        // The pauses make threads wait for each other.
        tbb::parallel_for(std::size_t(0), std::size_t(8), [&](std::size_t i) {
            std::this_thread::sleep_for(std::chrono::microseconds(20));
            sum += i;
        });
    };
    bool is_reporting = false;
    Progress progress;
    progress.report = [&](auto...) {
        entered_again += is_reporting;
        is_reporting = true;
        nested_loop();
        is_reporting = false;
    };
    const auto make_body = [&]() -> LoopBody {
        return [&, in_use = std::make_shared<bool>(false)](std::size_t) {
            entered_again += *in_use;
            *in_use = true;
            nested_loop();
            *in_use = false;
        };
    };
    with_threads(8, [&] { EXPECT_TRUE(parallel_loop({200, 2}, make_body, "nested", progress)); });
    EXPECT_EQ(sum, (200u + 100u) * 28u);
    EXPECT_EQ(entered_again, 0);
}

TEST(ParallelLoop, ReportsItsProgress) {
    Progress progress;
    std::vector<std::uint64_t> told;
    progress.report = [&](std::string_view stage, std::uint64_t done, std::uint64_t total) {
        EXPECT_EQ(stage, "counting");
        EXPECT_EQ(total, 100u);
        told.push_back(done);
    };
    EXPECT_TRUE(parallel_loop(
        {100, 30}, []() -> LoopBody { return [](std::size_t) {}; }, "counting", progress));
    ASSERT_EQ(told.size(), 4u);
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    EXPECT_EQ(told.back(), 100u);
}

TEST(ParallelLoop, EndsSoonAfterAStopRequest) {
    std::stop_source stop;
    std::atomic<std::size_t> done = 0;
    const Result<Done> stopped = parallel_loop({1000000, 1000},
                                               [&]() -> LoopBody {
                                                   return [&](std::size_t) {
                                                       if (++done == 10) stop.request_stop();
                                                   };
                                               },
                                               "counting", {{}, stop.get_token()});
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, ErrorCode::interrupted);
    EXPECT_LT(done, 1000u);

    done = 0;
    EXPECT_FALSE(parallel_loop({10, 1}, [&]() -> LoopBody { return [&](std::size_t) { ++done; }; },
                               "counting", {{}, stop.get_token()}));
    EXPECT_EQ(done, 0u);
}

}  // namespace
}  // namespace haarfield
