#include "fields/file/write_file.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

TEST(WriteFile, LeavesTheWholeFileAndNothingBesideIt) {
    const TestFolder folder;
    for (const std::string& text : {std::string("a rather long text"), std::string("short"), std::string(),
                                    std::string("zero\0inside", 11), std::string(1 << 20, 'x')}) {
        const Result<Done> written = write_file(folder / "a.txt", text);
        ASSERT_TRUE(written) << written.error().message();
        EXPECT_EQ(text_of(folder / "a.txt"), text);
        EXPECT_EQ(folder.files(), std::vector<std::string>{"a.txt"});
    }
}

TEST(WriteFile, SaysWhatItCanNotWriteAndLeavesWhatWasThere) {
    const TestFolder folder;
    const Result<Done> nowhere = write_file(folder / "missing" / "a.txt", "text");
    ASSERT_FALSE(nowhere);
    EXPECT_EQ(nowhere.error().where, (folder / "missing" / "a.txt").string());
    EXPECT_NE(nowhere.error().what.find("No such file or directory"), std::string::npos)
        << nowhere.error().what;

    std::filesystem::create_directory(folder / "a");
    EXPECT_FALSE(write_file(folder / "a", "text"));
    EXPECT_EQ(folder.files(), std::vector<std::string>{"a"});
    EXPECT_TRUE(std::filesystem::is_directory(folder / "a"));
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

TEST(MakeFolder, MakesAllThatIsMissing) {
    const TestFolder folder;
    for (int i = 0; i < 2; ++i) {  // the second time it is there
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
