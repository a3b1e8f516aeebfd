#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <tuple>

#include "scenes/image.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

/// Runs `haarfield relight` in a temporary folder.
class RelightCommand : public testing::Test {
protected:
    void SetUp() override {
        folder = std::filesystem::temp_directory_path() /
                 ("haarfield_relight_" +
                  std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
        std::ofstream(folder / "floor.obj") << "v -3 0 -3\nv 3 0 -3\nv 3 0 3\nv -3 0 3\nf 4 3 2 1\n";
        write_column();
        std::ofstream(folder / "room.toml") << R"(
[camera]
position = [2.5, 2, 3]
target = [0, 0.4, 0]
vertical_fov = 40
resolution = [64, 48]
[environment]
sky = { turbidity = 6, sun_elevation = 50, sun_azimuth = 20, sun_angular_radius = 5 }
[materials.clay]
diffuse = [0.6, 0.5, 0.4]
specular = [0.2, 0.2, 0.2]
shininess = 20
convention = "povray"
[entities.column]
mesh = "column.obj"
material = "clay"
fine_vertices = 300
coarse_triangles = 0
planar_samples = 100
spherical_samples = 150
[entities.floor]
mesh = "floor.obj"
material = "clay"
fine_vertices = 500
coarse_triangles = 0
[[instances]]
entity = "floor"
[[instances]]
entity = "column"
[[instances]]
entity = "column"
translate = [1, 0, 0.3]
)";
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    /// Writes a column of 96 triangles, which are enough for a field.
    void write_column() {
        constexpr int sides = 24;
        std::ofstream file(folder / "column.obj");
        for (const double height : {0.0, 1.0})
            for (int i = 0; i < sides; ++i)
                file << fmt::format("v {} {} {}\n", 0.3 * std::cos(6.2831853 * i / sides), height,
                                    -0.3 * std::sin(6.2831853 * i / sides));
        std::string bottom = "f", top = "f";
        for (int i = 0; i < sides; ++i) {
            const int next = (i + 1) % sides;
            file << fmt::format("f {} {} {} {}\n", i + 1, next + 1, next + 1 + sides, i + 1 + sides);
            top += fmt::format(" {}", i + 1 + sides);
            bottom += fmt::format(" {}", sides - i);
        }
        file << top << '\n' << bottom << '\n';
    }

    /// Runs the command and returns its exit code. `words` receives stderr.
    int run(const std::string& arguments, const std::string& environment = "") {
        const std::string command = fmt::format(
            "cd '{}' && {} {} relight room.toml -o out --fields fields --face-size 16 --frames 4 {} > "
            "out.txt 2> err.txt",
            folder.string(), environment, HAARFIELD_PROGRAM, arguments);
        const int status = std::system(command.c_str());
        std::ifstream file(folder / "err.txt");
        words.assign(std::istreambuf_iterator<char>(file), {});
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    Image frame(int number) const {
        const auto image = read_image(folder / "out" / fmt::format("frame_{:04}.png", number));
        EXPECT_TRUE(image) << image.error().message();
        return image ? *image : Image{};
    }

    std::filesystem::path folder;
    std::string words;
};

bool is_near(const Image& a, const Image& b, double tolerance) {
    double difference = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i)
        for (int c = 0; c < 3; ++c) difference += std::abs(double(a.pixels[i][c]) - double(b.pixels[i][c]));
    return difference / double(3 * a.pixels.size()) < tolerance;
}

TEST_F(RelightCommand, SpinsTheLightAndReports) {
    ASSERT_EQ(run("--spin-light --report report.json"), 0) << words;
    std::ifstream file(folder / "report.json");
    const nlohmann::json report = nlohmann::json::parse(file);
    EXPECT_EQ(report["mode"], "spin-light");
    EXPECT_EQ(report["frames"], 4);
    for (const char* key :
         {"scene_seconds", "vector_seconds", "frames_per_second", "preview_seconds", "transfer_bytes",
          "setup_processor_seconds", "scene_processor_seconds", "vector_processor_seconds",
          "frame_processor_seconds", "preview_processor_seconds"})
        EXPECT_GT(report[key], 0) << key;
    EXPECT_NEAR(report["frames_per_second"].get<double>() * report["frame_seconds"].get<double>(), 1, 1e-9);
    EXPECT_EQ(report["setup_seconds"].get<double>() - report["scene_seconds"].get<double>(),
              report["vector_seconds"].get<double>());
    EXPECT_FALSE(report.contains("rest_seconds"));
    const Image first = frame(1), second = frame(2);
    EXPECT_EQ(first.width, 64);
    EXPECT_EQ(first.height, 48);
    EXPECT_FALSE(is_near(first, second, 0.005));
    EXPECT_FALSE(std::filesystem::exists(folder / "out/frame_0005.png"));
}

TEST_F(RelightCommand, FirstFramesOfAllModesAreOneScene) {
    ASSERT_EQ(run("--spin-light"), 0) << words;
    const Image wanted = frame(1);
    ASSERT_EQ(run("--orbit"), 0) << words;
    EXPECT_TRUE(is_near(frame(1), wanted, 0.006));
    EXPECT_FALSE(is_near(frame(2), wanted, 0.02));
    ASSERT_EQ(run("--move column_2 0.5,0.6,-0.2:0,0,1"), 0) << words;
    EXPECT_TRUE(is_near(frame(1), wanted, 0.006));
    EXPECT_FALSE(is_near(frame(2), wanted, 0.005));
}

TEST_F(RelightCommand, FadesFromOneLightToTheOther) {
    for (const auto& [name, radiance] : {std::pair("dim.exr", 0.2f), std::pair("bright.exr", 0.8f)})
        ASSERT_TRUE(write_image({32, 16, std::vector<Rgb>(32 * 16, Rgb(radiance)), {}}, folder / name));
    ASSERT_EQ(run("--lights dim.exr,bright.exr --format exr"), 0) << words;
    const auto at = [&](int number) {
        const auto image = read_image(folder / "out" / fmt::format("frame_{:04}.exr", number));
        return image->pixels[24 * 64 + 32].x;
    };
    EXPECT_NEAR(at(4) / at(1), 4, 0.1);
    EXPECT_NEAR(at(2) / at(1), 2, 0.1);
}

TEST_F(RelightCommand, WritesScenesForPovray) {
    ASSERT_EQ(run("--move column_2 0,0,1 --format povray"), 0) << words;
    for (const char* file :
         {"frame_0001/room.pov", "frame_0001/room_Column_2.inc", "frame_0004/room_Floor.inc"})
        EXPECT_TRUE(std::filesystem::exists(folder / "out" / file)) << file;
}

TEST_F(RelightCommand, MovesAndTurnsSeveralInstancesAtOnce) {
    ASSERT_EQ(run("--move column_2 0,0,1:-1,0.4,0.5 --rotate column_2 0,0,90 --rotate column_1 20,0,0 "
                  "--move column_1 0.5,0.2,0 --report report.json"),
              0)
        << words;
    std::ifstream file(folder / "report.json");
    EXPECT_EQ(nlohmann::json::parse(file)["mode"], "move");
    const Image start = frame(1), end = frame(4);
    EXPECT_FALSE(is_near(frame(2), start, 0.005));
    EXPECT_FALSE(is_near(frame(3), frame(2), 0.005));

    ASSERT_EQ(run("--spin-light"), 0) << words;
    EXPECT_TRUE(is_near(start, frame(1), 0.006));
    const std::string scene = text_of(folder / "room.toml");
    const std::string columns = "[[instances]]\nentity = \"column\"\n";
    std::ofstream(folder / "room.toml") << scene.substr(0, scene.find(columns))
                                        << columns + "translate = [0.5, 0.2, 0]\nrotate = [20, 0, 0]\n" +
                                               columns + "translate = [-1, 0.4, 0.5]\nrotate = [0, 0, 90]\n";
    ASSERT_EQ(run("--spin-light"), 0) << words;
    EXPECT_TRUE(is_near(end, frame(1), 0.006));
}

TEST_F(RelightCommand, FollowsKeyframes) {
    EXPECT_EQ(run("--keyframes"), 1);
    EXPECT_NE(words.find("--keyframes: the scene has no [[keyframes]] after time 0"), std::string::npos)
        << words;
    EXPECT_EQ(run("--keyframes --orbit"), 2);
    // In frames 1 to 4 column_1 is turned by 0, 45, 90 and 90 degrees, and column_2 at x = -1, -1, 0 and 1.
    const std::string scene = text_of(folder / "room.toml");
    std::ofstream(folder / "room.toml", std::ios::app) << R"(
[[keyframes]]
time = 2
instance = "column_1"
rotate = [0, 0, 90]
[[keyframes]]
time = 0
instance = "column_2"
translate = [-1, 0, 0.3]
[[keyframes]]
time = 1
instance = "column_2"
translate = [-1, 0, 0.3]
[[keyframes]]
time = 3
instance = "column_2"
translate = [1, 0, 0.3]
)";
    ASSERT_EQ(run("--keyframes"), 0) << words;
    const std::array<Image, 4> frames{frame(1), frame(2), frame(3), frame(4)};
    for (const auto& [number, turn, x] : {std::tuple(0u, 0, -1), {1u, 45, -1}, {2u, 90, 0}, {3u, 90, 1}}) {
        std::ofstream(folder / "room.toml")
            << scene.substr(0, scene.find("[[instances]]\nentity = \"column\"\n"))
            << fmt::format(R"([[instances]]
entity = "column"
rotate = [0, 0, {}]
[[instances]]
entity = "column"
translate = [{}, 0, 0.3]
)",
                           turn, x);
        ASSERT_EQ(run("--spin-light"), 0) << words;
        EXPECT_TRUE(is_near(frames[number], frame(1), 0.006)) << number;
    }
    EXPECT_FALSE(is_near(frames[2], frames[3], 0.01));
}

/// Tests scale alone, which transfer vectors follow, and scale with rotation, which is shaded in full. There
/// are no bounces, because frames of transfer vectors do not update them.
TEST_F(RelightCommand, FollowsKeyframesOfSize) {
    const std::string room = text_of(folder / "room.toml");
    for (const auto& [at_time_3, turn] :
         {std::pair("scale = 2\n", 0), std::pair("rotate = [0, 0, 90]\nscale = 2\n", 90)}) {
        std::ofstream(folder / "room.toml") << room << R"(scale = 0.8
[[keyframes]]
time = 1
instance = "column_2"
scale = 1
[[keyframes]]
time = 3
instance = "column_2"
)" << at_time_3;
        ASSERT_EQ(run("--keyframes --bounces 0"), 0) << words;
        const std::array<Image, 4> frames{frame(1), frame(2), frame(3), frame(4)};
        for (const auto& [number, share, scale] :
             {std::tuple(0, 0.0, 0.8), {1, 1 / 3.0, 0.8}, {2, 2 / 3.0, 1.2}, {3, 1.0, 1.6}}) {
            std::ofstream(folder / "room.toml")
                << room << fmt::format("scale = {}\nrotate = [0, 0, {}]\n", scale, turn * share);
            ASSERT_EQ(run("--spin-light --bounces 0"), 0) << words;
            EXPECT_TRUE(is_near(frames[std::size_t(number)], frame(1), 0.006)) << number << ", " << turn;
        }
        EXPECT_FALSE(is_near(frames[1], frames[2], 0.01)) << turn;
        EXPECT_FALSE(is_near(frames[2], frames[3], 0.01)) << turn;
    }
}

TEST_F(RelightCommand, ReportsAMissingFfmpegBeforeTheFirstFrame) {
    EXPECT_EQ(run("--orbit --movie spin.mp4", "PATH=/nowhere"), 1);
    EXPECT_NE(words.find("ffmpeg is not installed"), std::string::npos) << words;
    EXPECT_FALSE(std::filesystem::exists(folder / "out/frame_0001.png"));
    EXPECT_FALSE(std::filesystem::exists(folder / "spin.mp4"));
}

TEST_F(RelightCommand, RefusesImpossibleRequests) {
    EXPECT_EQ(run(""), 2);
    EXPECT_EQ(run("--orbit --spin-light"), 2);
    EXPECT_EQ(run("--orbit --frames 0"), 2);
    EXPECT_EQ(run("--orbit --pruning-error nan"), 2);
    EXPECT_EQ(run("--spin-light --axis 0,nan,0"), 2);
    EXPECT_EQ(run("--orbit --axis 0,1,0"), 2);
    const auto fails = [&](const std::string& arguments, const std::string& with) {
        EXPECT_EQ(run(arguments), 1) << arguments;
        EXPECT_NE(words.find(with), std::string::npos) << words;
    };
    fails("--spin-light --axis 0,0,0", "has length 0");
    fails("--lights a.exr", "two or more");
    fails("--lights a.exr,b.exr", "a.exr");
    fails("--move chair 0,0,0", "--move: unknown instance chair; expected one of floor, column_1, column_2");
    fails("--rotate chair 0,0,0", "--rotate: unknown instance chair");
    fails("--move column_1 0,0,0 --move floor 1,0,0 --move column_1 1,0,0", "--move: names column_1 twice");
    fails("--rotate floor 0,0,0 --rotate floor 1,0,0", "--rotate: names floor twice");
    EXPECT_EQ(run("--orbit --rotate column_1 0,90,0"), 2);
    EXPECT_EQ(run("--move floor 1,0,0 --spin-light"), 2);
    EXPECT_EQ(run("--rotate column_1 0,90"), 2);
    EXPECT_NE(words.find("--rotate: is 0,90; expected degrees X,Y,Z"), std::string::npos) << words;
    for (const char* path : {"0,0", "0,0,0:", "0,0,nan", "0,0,inf", "0,0,0,0", "0,0,1000001", "0,,0"}) {
        EXPECT_EQ(run(std::string("--move column_1 ") + path), 2) << path;
        EXPECT_NE(words.find(std::string("--move: is ") + path + "; expected positions X,Y,Z"),
                  std::string::npos)
            << words;
    }
    fails("--orbit --format exr --movie spin.mp4", "PNG");
}

}  // namespace
}  // namespace haarfield
