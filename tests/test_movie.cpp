#include "bridge/files/movie.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

namespace haarfield {
namespace {

/// A folder with a program that replaces ffmpeg.
class MovieTest : public testing::Test {
protected:
    void SetUp() override {
        folder =
            std::filesystem::temp_directory_path() /
            ("haarfield_movie_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    std::string program(const std::string& script) {
        const std::filesystem::path file = folder / "encoder";
        std::ofstream(file) << "#!/bin/sh\n" << script;
        std::filesystem::permissions(file, std::filesystem::perms::owner_all);
        return file.string();
    }

    /// Returns the files of the folder, except the program.
    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder))
            if (entry.path().filename() != "encoder") names.push_back(entry.path().filename());
        return names;
    }

    std::filesystem::path folder;
};

TEST_F(MovieTest, PassesPicturesAndRateAndLeavesTheWholeMovie) {
    // The last argument is the output, to which the program writes all arguments.
    const std::string encoder = program("for last; do :; done; echo \"$@\" > \"$last\"\n");
    const auto written = write_movie(folder / "frame_%04d.png", 24, folder / "spin.mp4", 30, {}, encoder);
    ASSERT_TRUE(written) << written.error().message();
    EXPECT_EQ(files(), std::vector<std::string>{"spin.mp4"});
    std::ifstream file(folder / "spin.mp4");
    std::string arguments;
    std::getline(file, arguments);
    EXPECT_NE(arguments.find("-framerate 30"), std::string::npos) << arguments;
    EXPECT_NE(arguments.find("-i " + (folder / "frame_%04d.png").string()), std::string::npos) << arguments;
    EXPECT_NE(arguments.find("-start_number 1 "), std::string::npos) << arguments;
    EXPECT_NE(arguments.find("-frames:v 24 "), std::string::npos) << "others may lie there: " << arguments;
    EXPECT_NE(arguments.find("yuv420p"), std::string::npos) << arguments;
    EXPECT_EQ(arguments.substr(arguments.size() - 4), ".mp4") << arguments;
}

TEST_F(MovieTest, ChecksForTheEncoder) {
    EXPECT_TRUE(check_encoder(program("exit 0\n")));
    const Result<Done> missing = check_encoder("no-such-ffmpeg");
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message().find("no-such-ffmpeg is not installed"), std::string::npos);
}

TEST_F(MovieTest, FollowsLinksWritesToPipesAndRefusesDirectories) {
    const std::string encoder = program("for last; do :; done; printf movie > \"$last\"\n");
    const auto write = [&](const char* name) {
        return write_movie(folder / "frame_%04d.png", 24, folder / name, 30, {}, encoder);
    };
    const auto content = [&](const char* name) {
        std::ostringstream text;
        text << std::ifstream(folder / name).rdbuf();
        return text.str();
    };
    std::filesystem::create_symlink("spin.mp4", folder / "link.mp4");
    ASSERT_TRUE(write("link.mp4"));
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.mp4"));
    EXPECT_EQ(content("spin.mp4"), "movie");

    ASSERT_EQ(mkfifo((folder / "pipe.mp4").c_str(), 0600), 0);
    std::string read;
    std::thread reader([&] { read = content("pipe.mp4"); });
    const Result<Done> piped = write("pipe.mp4");
    // Without this, a failure would leave the reader waiting.
    if (const int end = open((folder / "pipe.mp4").c_str(), O_WRONLY | O_NONBLOCK); end >= 0) close(end);
    reader.join();
    EXPECT_TRUE(piped);
    EXPECT_EQ(read, "movie");
    EXPECT_TRUE(std::filesystem::is_fifo(folder / "pipe.mp4"));

    std::filesystem::create_directory(folder / "folder.mp4");
    const Result<Done> refused = write("folder.mp4");
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().what.find("is a directory"), std::string::npos) << refused.error().what;
    EXPECT_EQ(files().size(), 4u) << "nothing else is left";
}

TEST_F(MovieTest, ReportsAMissingEncoder) {
    const auto written =
        write_movie(folder / "frame_%04d.png", 24, folder / "spin.mp4", 24, {}, "no-such-ffmpeg");
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message().find("no-such-ffmpeg is not installed"), std::string::npos);
    EXPECT_TRUE(files().empty());
}

TEST_F(MovieTest, ReportsItsMessagesAndLeavesNothing) {
    const std::string encoder =
        program("for last; do :; done; echo half > \"$last\"; echo 'Unknown encoder' >&2; exit 1\n");
    const auto written = write_movie(folder / "frame_%04d.png", 24, folder / "spin.mp4", 24, {}, encoder);
    ASSERT_FALSE(written);
    EXPECT_NE(written.error().message().find("Unknown encoder"), std::string::npos)
        << written.error().message();
    EXPECT_TRUE(files().empty());
}

TEST_F(MovieTest, StopsWhenAsked) {
    const std::string encoder = program("for last; do :; done; echo half > \"$last\"; exec sleep 60\n");
    std::stop_source stop;
    stop.request_stop();
    const auto written =
        write_movie(folder / "frame_%04d.png", 24, folder / "spin.mp4", 24, {{}, stop.get_token()}, encoder);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().code, ErrorCode::interrupted);
    EXPECT_TRUE(files().empty());
}

}  // namespace
}  // namespace haarfield
