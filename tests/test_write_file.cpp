#include "fields/file/write_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <array>
#include <thread>
#include <vector>

#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

TEST(WriteFile, LeavesTheCompleteFileAndNoOther) {
    const TestFolder folder;
    for (const std::string& text : {std::string("a rather long text"), std::string("short"), std::string(),
                                    std::string("zero\0inside", 11), std::string(1 << 20, 'x')}) {
        const Result<Done> written = write_file(folder / "a.txt", text);
        ASSERT_TRUE(written) << written.error().message();
        EXPECT_EQ(text_of(folder / "a.txt"), text);
        EXPECT_EQ(folder.files(), std::vector<std::string>{"a.txt"});
    }
}

TEST(WriteFile, ErrorsNameTheFileAndLeaveItUnchanged) {
    const TestFolder folder;
    const Result<Done> nowhere = write_file(folder / "missing" / "a.txt", "text");
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().where, (folder / "missing" / "a.txt").string());
    EXPECT_NE(nowhere.error().what.find("No such file or directory"), std::string::npos)
        << nowhere.error().what;

    std::filesystem::create_directory(folder / "a");
    const Result<Done> directory = write_file(folder / "a", "text");
    ASSERT_FALSE(directory);
    EXPECT_NE(directory.error().what.find("is a directory"), std::string::npos) << directory.error().what;
    EXPECT_EQ(folder.files(), std::vector<std::string>{"a"});
    EXPECT_TRUE(std::filesystem::is_directory(folder / "a"));
}

TEST(WriteFile, FollowsLinksAlsoToFilesThatDoNotExistYet) {
    const TestFolder folder;
    std::filesystem::create_directory(folder / "elsewhere");
    write_text(folder / "elsewhere/there", "before");
    std::filesystem::create_symlink("elsewhere/there", folder / "link");
    std::filesystem::create_symlink("link", folder / "link_to_link");
    std::filesystem::create_symlink(folder / "elsewhere/new", folder / "dangling");
    for (const char* name : {"link_to_link", "dangling"}) {
        const Result<Done> written = write_file(folder / name, name);
        ASSERT_TRUE(written) << written.error().message();
        EXPECT_TRUE(std::filesystem::is_symlink(folder / name)) << name;
        EXPECT_EQ(text_of(folder / name), name);
    }
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
    EXPECT_EQ(text_of(folder / "elsewhere/there"), "link_to_link");
    EXPECT_EQ(text_of(folder / "elsewhere/new"), "dangling");

    std::filesystem::create_symlink("round", folder / "round");
    const Result<Done> round = write_file(folder / "round", "text");
    ASSERT_FALSE(round);
    EXPECT_NE(round.error().what.find("symbolic links"), std::string::npos) << round.error().what;
}

TEST(WriteFile, WritesToPipes) {
    const TestFolder folder;
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    std::filesystem::create_symlink("pipe", folder / "link");
    for (const char* name : {"pipe", "link"}) {
        std::string read;
        std::thread reader([&] { read = text_of(folder / "pipe"); });
        const std::string text(200000, 'p');  // more than the capacity of a pipe
        const Result<Done> written = write_file(folder / name, text);
        // Otherwise, a failure would leave the reader waiting.
        if (const int end = open((folder / "pipe").c_str(), O_WRONLY | O_NONBLOCK); end >= 0) close(end);
        reader.join();
        ASSERT_TRUE(written) << written.error().message();
        EXPECT_EQ(read, text) << name;
        EXPECT_TRUE(std::filesystem::is_fifo(folder / "pipe")) << name;
    }
    EXPECT_EQ(folder.files().size(), 2u) << "no temporary file is left";
}

TEST(WriteFile, WritesToDevicesAndReportsThatOneIsFull) {
    const TestFolder folder;
    // Copies of /dev/null and /dev/full, because a failure must not replace the system's devices.
    for (const auto& [name, minor] : {std::pair("null", 3u), std::pair("full", 7u)})
        if (mknod((folder / name).c_str(), S_IFCHR | 0600, makedev(1, minor)) != 0 ||
            open((folder / name).c_str(), O_WRONLY | O_CLOEXEC) < 0)
            GTEST_SKIP() << "this process cannot make devices";
    EXPECT_TRUE(write_file(folder / "null", "text"));
    const Result<Done> full = write_file(folder / "full", "text");
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().where, (folder / "full").string());
    EXPECT_NE(full.error().what.find("No space left"), std::string::npos) << full.error().what;
    for (const char* name : {"null", "full"})
        EXPECT_TRUE(std::filesystem::is_character_file(folder / name)) << name;
    EXPECT_EQ(folder.files(), (std::vector<std::string>{"full", "null"}));
}

TEST(WriteFile, FromManyThreadsLeavesOneOfTheTexts) {
    const TestFolder folder;
    std::vector<std::thread> threads;
    for (char letter = 'a'; letter < 'e'; ++letter)
        threads.emplace_back([&, letter] {
            for (int i = 0; i < 5; ++i) EXPECT_TRUE(write_file(folder / "file", std::string(5000, letter)));
        });
    for (std::thread& thread : threads) thread.join();
    const std::string text = text_of(folder / "file");
    ASSERT_EQ(text.size(), 5000u);
    EXPECT_EQ(text, std::string(5000, text[0]));
    EXPECT_EQ(folder.files(), std::vector<std::string>{"file"});
}

TEST(MakeFolder, CreatesAllMissingFolders) {
    const TestFolder folder;
    for (int i = 0; i < 2; ++i) {  // the second time, it exists
        EXPECT_TRUE(make_folder(folder / "a/b"));
        EXPECT_TRUE(std::filesystem::is_directory(folder / "a/b"));
    }
    write_text(folder / "file", "text");
    for (const char* name : {"file", "file/below"}) {
        const Result<Done> made = make_folder(folder / name);
        ASSERT_FALSE(made) << name;
        EXPECT_EQ(made.error().where, (folder / name).string());
    }
}

}  // namespace
}  // namespace haarfield
