#include "fields/file/temporary_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/fsuid.h>
#include <sys/wait.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

using std::filesystem::path;

Result<Done> write_whole(const path& target, std::string_view text) {
    Result<TemporaryFile> temporary = TemporaryFile::beside(target);
    if (!temporary) return temporary.error();
    if (Result<Done> written = temporary->write(text); !written) return written;
    return temporary->replace_target(text);
}

TEST(TemporaryFile, TakesTheTargetsPlaceWholeOrNotAtAll) {
    const TestFolder folder;
    ASSERT_TRUE(write_whole(folder / "target", "first"));
    {
        Result<TemporaryFile> temporary = TemporaryFile::beside(folder / "target");
        ASSERT_TRUE(temporary);
        EXPECT_TRUE(temporary->write("sec"));
        EXPECT_TRUE(temporary->write("ond"));
        EXPECT_EQ(text_of(folder / "target"), "first");
        EXPECT_FALSE(temporary->replace_target("seconds")) << "not what was written";
        EXPECT_EQ(text_of(folder / "target"), "first");
        EXPECT_TRUE(temporary->replace_target("second"));
        EXPECT_EQ(text_of(folder / "target"), "second");
    }
    { const auto unused = TemporaryFile::beside(folder / "target"); }
    EXPECT_EQ(text_of(folder / "target"), "second");
    EXPECT_EQ(folder.files(), std::vector<std::string>{"target"});
}

TEST(TemporaryFile, OneAtATimeForEachTarget) {
    const TestFolder folder;
    std::atomic<int> holders = 0, turns = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 5; ++i) {
                Result<TemporaryFile> temporary = TemporaryFile::beside(folder / "target");
                ASSERT_TRUE(temporary);
                EXPECT_EQ(++holders, 1);
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
                EXPECT_TRUE(temporary->write("x"));
                --holders;
                ++turns;
                if (i % 2 == 0) {
                    EXPECT_TRUE(temporary->replace_target("x"));
                }
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(turns, 20);
    EXPECT_EQ(folder.files(), std::vector<std::string>{"target"});
    const auto held = TemporaryFile::beside(folder / "target");
    EXPECT_TRUE(TemporaryFile::beside(folder / "another"));
}

TEST(TemporaryFile, WaitingSaysSoAndEndsWhenAskedTo) {
    const TestFolder folder;
    const auto held = TemporaryFile::beside(folder / "target");
    ASSERT_TRUE(held);
    std::stop_source stop;
    Progress progress;
    progress.stop = stop.get_token();
    std::string said;
    progress.report = [&](std::string_view stage, std::uint64_t, std::uint64_t) {
        said = stage;
        stop.request_stop();
    };
    const auto waited = TemporaryFile::beside(folder / "target", progress);
    ASSERT_FALSE(waited);
    EXPECT_EQ(waited.error().what, interrupted);
    EXPECT_NE(said.find("waiting"), std::string::npos) << said;
    EXPECT_NE(said.find("target"), std::string::npos) << said;
}

/// Ends a child process by SIGKILL while it holds a temporary file with something in it.
void leave_behind(const path& target) {
    const pid_t child = fork();
    if (child == 0) {
        Result<TemporaryFile> temporary = TemporaryFile::beside(target);
        const bool written = temporary && temporary->write("half a fi");
        kill(getpid(), written ? SIGKILL : SIGTERM);
        pause();
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
}

TEST(TemporaryFile, WhatAKilledProcessLeftIsUsedOrRemoved) {
    const TestFolder folder;
    leave_behind(folder / "target");
    ASSERT_EQ(folder.files(), std::vector<std::string>{"target.tmp"});
    ASSERT_TRUE(write_whole(folder / "target", "whole"));
    EXPECT_EQ(text_of(folder / "target"), "whole");
    EXPECT_EQ(folder.files(), std::vector<std::string>{"target"});

    leave_behind(folder / "target");
    leave_behind(folder / "another");
    write_text(folder / "notes.txt", "not ours");
    const auto held = TemporaryFile::beside(folder / "held");
    remove_abandoned_files(folder.path());
    EXPECT_EQ(folder.files(), (std::vector<std::string>{"held.tmp", "notes.txt", "target"}));
    remove_abandoned_files(folder / "missing");
}

TEST(TemporaryFile, NoFolderAndAReadOnlyOneAreErrors) {
    const TestFolder folder;
    const auto missing = TemporaryFile::beside(folder / "missing" / "target");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().where, (folder / "missing" / "target").string());

    std::filesystem::create_directory(folder / "folder");
    std::filesystem::permissions(folder / "folder", std::filesystem::perms(0555));
    const int before = setfsuid(65534);  // root may write anywhere; `nobody` may not
    const auto refused = TemporaryFile::beside(folder / "folder" / "target");
    setfsuid(static_cast<uid_t>(before));
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().what.find("Permission denied"), std::string::npos) << refused.error().what;
    std::filesystem::permissions(folder / "folder", std::filesystem::perms(0755));

    std::filesystem::create_directory(folder / "target");
    EXPECT_FALSE(write_whole(folder / "target", "x")) << "a folder has the name";
    EXPECT_FALSE(std::filesystem::exists(folder / "target.tmp"));
}

}  // namespace
}  // namespace haarfield
