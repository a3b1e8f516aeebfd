#include "fields/file/claim.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <string>
#include <vector>

#include "fields/file/process_name.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

TEST(Claim, IsHeldByOneProcessAtATime) {
    const TestFolder folder;
    std::atomic<int> holders = 0, turns = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 5; ++i) {
                const Result<std::optional<Claim>> claim = Claim::on(folder / "work.claim");
                ASSERT_TRUE(claim) << claim.error().message();
                ASSERT_TRUE(*claim);
                EXPECT_EQ(++holders, 1);
                std::this_thread::sleep_for(milliseconds(1));
                --holders;
                ++turns;
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(turns, 20);
    EXPECT_EQ(folder.files(), std::vector<std::string>());
}

TEST(Claim, WaitingReportsProgressAndCanBeInterrupted) {
    const TestFolder folder;
    const auto held = Claim::on(folder / "work.claim");
    ASSERT_TRUE(held && *held);
    EXPECT_EQ(text_of(folder / "work.claim"), process_name());
    std::stop_source stop;
    Progress progress;
    progress.stop = stop.get_token();
    std::string said;
    progress.report = [&](std::string_view stage, std::uint64_t, std::uint64_t) {
        said = stage;
        stop.request_stop();
    };
    const auto waited = Claim::on(folder / "work.claim", progress);
    ASSERT_FALSE(waited);
    EXPECT_EQ(waited.error().code, ErrorCode::interrupted);
    EXPECT_NE(said.find("waiting"), std::string::npos) << said;
}

TEST(Claim, OfAKilledProcessIsReplacedAtOnceOrRemoved) {
    const TestFolder folder;
    for (const char* name : {"a.claim", "b.claim"}) {
        const pid_t child = fork();
        if (child == 0) {
            const auto claim = Claim::on(folder / name);
            kill(getpid(), claim && *claim ? SIGKILL : SIGTERM);
            pause();
        }
        int status = 0;
        waitpid(child, &status, 0);
        ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    }
    ASSERT_EQ(folder.files(), (std::vector<std::string>{"a.claim", "b.claim"}));
    const auto claim = Claim::on(folder / "a.claim", {}, std::chrono::hours(1));
    ASSERT_TRUE(claim && *claim);
    remove_abandoned_claims(folder.path());
    EXPECT_EQ(folder.files(), std::vector<std::string>{"a.claim"}) << "this process is running";
}

TEST(Claim, OfAnotherMachineHoldsWhileItIsRenewed) {
    const TestFolder folder;
    write_text(folder / "work.claim", "0123456789ab-1-1");
    constexpr milliseconds patience(300);
    std::atomic<bool> taken = false;
    std::jthread waiting([&] {
        const auto claim = Claim::on(folder / "work.claim", {}, patience);
        EXPECT_TRUE(claim && *claim);
        taken = true;
    });
    const Clock::time_point begin = Clock::now();
    auto last = begin;
    while (Clock::now() - begin < 3 * patience) {  // with any clock of the other machine
        std::filesystem::last_write_time(folder / "work.claim",
                                         std::filesystem::file_time_type(Clock::now().time_since_epoch()));
        std::this_thread::sleep_for(milliseconds(10));
        if (Clock::now() - last > patience / 2) break;  // the machine is too busy for this test
        last = Clock::now();
        EXPECT_FALSE(taken);
    }
    waiting.join();
    EXPECT_TRUE(taken);
    EXPECT_EQ(folder.files(), std::vector<std::string>());
}

TEST(Claim, NoFolderIsAnError) {
    const TestFolder folder;
    const auto claim = Claim::on(folder / "missing" / "work.claim");
    ASSERT_FALSE(claim);
    EXPECT_EQ(claim.error().where, (folder / "missing" / "work.claim").string());
}

}  // namespace
}  // namespace haarfield
