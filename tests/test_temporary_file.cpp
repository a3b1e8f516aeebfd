#include "fields/file/temporary_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/fsuid.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <chrono>
#include <thread>

#include "fields/file/process_name.h"
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

TEST(TemporaryFile, ReplacesTheTargetCompletelyOrNotAtAll) {
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

TEST(TemporaryFile, SeveralOfOneTargetDoNotDisturbEachOther) {
    const TestFolder folder;
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < 5; ++i) {
                const std::string text(1000, static_cast<char>('a' + t));
                Result<TemporaryFile> temporary = TemporaryFile::beside(folder / "target");
                ASSERT_TRUE(temporary) << temporary.error().message();
                EXPECT_TRUE(temporary->write(text));
                if (i % 2 == 0) {
                    EXPECT_TRUE(temporary->replace_target(text));
                }
            }
        });
    for (std::thread& thread : threads) thread.join();
    const std::string left = text_of(folder / "target");
    EXPECT_EQ(left, std::string(1000, left[0]));
    EXPECT_EQ(folder.files(), std::vector<std::string>{"target"});
}

TEST(TemporaryFile, TakesTargetsWithNamesOfAnyLength) {
    const TestFolder folder;
    const std::string longest(255, 'n');
    ASSERT_TRUE(write_whole(folder / longest, "text"));
    EXPECT_EQ(folder.files(), std::vector<std::string>{longest});
}

/// Kills a child process with SIGKILL while it has a non-empty temporary file.
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

TEST(TemporaryFile, OnlyFilesOfKilledProcessesAreRemoved) {
    const TestFolder folder;
    leave_behind(folder / "target");
    ASSERT_EQ(folder.files().size(), 1u);
    EXPECT_TRUE(folder.files()[0].starts_with("target.")) << folder.files()[0];
    ASSERT_TRUE(write_whole(folder / "target", "whole"));
    leave_behind(folder / "another");
    write_text(folder / "notes.txt", "not ours");
    write_text(folder / "notes.tmp", "nor this");
    // A process of another machine: it may be running, but has not written for two days.
    write_text(folder / "field.0123456789ab-1-1.0.tmp", "new");
    write_text(folder / "field.0123456789ab-1-1.1.tmp", "old");
    std::filesystem::last_write_time(folder / "field.0123456789ab-1-1.1.tmp",
                                     std::filesystem::file_time_type::clock::now() - std::chrono::hours(48));
    const Result<TemporaryFile> held = TemporaryFile::beside(folder / "held");
    remove_abandoned_files(folder.path());
    const std::vector<std::string> files = folder.files();
    ASSERT_EQ(files.size(), 5u);
    EXPECT_EQ(files[0], "field.0123456789ab-1-1.0.tmp");
    EXPECT_TRUE(files[1].starts_with("held.")) << files[1];
    EXPECT_EQ(files[2], "notes.tmp");
    EXPECT_EQ(files[3], "notes.txt");
    EXPECT_EQ(files[4], "target");
    remove_abandoned_files(folder / "missing");
}

TEST(ProcessName, DistinguishesRunningFromEndedProcesses) {
    const std::string own = process_name();
    EXPECT_EQ(process_name(), own);
    EXPECT_EQ(process_liveness(own), Liveness::alive);
    const pid_t child = fork();
    if (child == 0) _exit(0);
    siginfo_t ended{};
    waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED);
    const std::string place = own.substr(0, own.find('-'));
    EXPECT_EQ(process_liveness(place + "-" + std::to_string(child) + "-1"), Liveness::ended);
    EXPECT_EQ(process_liveness(place + "-" + std::to_string(getpid()) + "-1"), Liveness::ended)
        << "an earlier process with this one's number";
    for (const std::string& other : {std::string("0123456789ab-1-1"), std::string(), place, place + "-x-1",
                                     place + "-1", place + "-1-", place + "--1-5", place + "-1-1x"})
        EXPECT_EQ(process_liveness(other), Liveness::unknown) << other;
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
    EXPECT_FALSE(write_whole(folder / "target", "x")) << "a directory has this name";
    EXPECT_EQ(folder.files(), (std::vector<std::string>{"folder", "target"}));
}

TEST(TemporaryFile, FollowsLinksAndRefusesPipes) {
    const TestFolder folder;
    std::filesystem::create_symlink("target", folder / "link");
    ASSERT_TRUE(write_whole(folder / "link", "text"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
    EXPECT_EQ(text_of(folder / "target"), "text");
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    const auto refused = TemporaryFile::beside(folder / "pipe");
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().what.find("a pipe"), std::string::npos) << refused.error().what;
    EXPECT_EQ(folder.files().size(), 3u) << "no temporary file is left";
}

}  // namespace
}  // namespace haarfield
