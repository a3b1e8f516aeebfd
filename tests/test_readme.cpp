#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include "scenes/scene_reader.h"

namespace haarfield {
namespace {

std::string readme() {
    std::ifstream file(std::filesystem::path(HAARFIELD_SOURCE_DIR) / "README.md");
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

TEST(Readme, FirstSceneCanBeRead) {
    const std::string text = readme();
    const std::size_t start = text.find("    [entities.chair]"), end = text.find("Saved as `first.toml`");
    ASSERT_NE(start, std::string::npos);
    ASSERT_NE(end, std::string::npos);
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "haarfield_readme";
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    std::filesystem::create_directory_symlink(std::filesystem::path(HAARFIELD_SOURCE_DIR) / "scenes",
                                              folder / "scenes");
    std::ofstream(folder / "first.toml") << text.substr(start, end - start);
    const Result<Scene> scene = read_scene(folder / "first.toml");
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->instances.size(), 1u);
    std::filesystem::remove_all(folder);
}

TEST(Readme, NamesOnlyCommandsAndOptionsThatThereAre) {
    const std::string text = readme();
    std::set<std::string> commands;
    const std::regex in_table("\\n\\| `(\\w+) [A-Z]|, `(\\w+) FIELD");
    for (std::sregex_iterator match(text.begin(), text.end(), in_table), end; match != end; ++match)
        commands.insert((*match)[1].matched ? (*match)[1] : (*match)[2]);
    EXPECT_EQ(commands, (std::set<std::string>{"bake", "budget", "compare", "info", "precompute", "reference",
                                               "relight", "verify"}));
    std::string help;
    for (const std::string& command : commands) {
        const std::filesystem::path output =
            std::filesystem::temp_directory_path() / ("haarfield_help_" + command);
        ASSERT_EQ(
            std::system(
                (std::string(HAARFIELD_PROGRAM) + " " + command + " --help > " + output.string()).c_str()),
            0);
        std::ifstream file(output);
        help.append(std::istreambuf_iterator<char>(file), {});
        std::filesystem::remove(output);
    }
    const std::regex option("[ `](--[a-z][a-z-]+)");
    for (std::sregex_iterator match(text.begin(), text.end(), option), end; match != end; ++match)
        if ((*match)[1] != "--install") {
            EXPECT_NE(help.find((*match)[1]), std::string::npos) << (*match)[1];
        }
}

TEST(Readme, NamesOnlyFilesThatThereAre) {
    const std::string text = readme();
    const std::regex file(
        "(scenes/[a-z_]+\\.(?:toml|png)|scenes/meshes/[a-z]+\\.obj|tools/(?:demo|test|packages\\.txt))");
    int count = 0;
    for (std::sregex_iterator match(text.begin(), text.end(), file), end; match != end; ++match, ++count)
        EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(HAARFIELD_SOURCE_DIR) / (*match)[1].str()))
            << (*match)[1];
    EXPECT_GE(count, 6);
}

}  // namespace
}  // namespace haarfield
