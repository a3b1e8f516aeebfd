#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "scenes/scene_reader.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

std::string readme() {
    return text_of(std::filesystem::path(HAARFIELD_SOURCE_DIR) / "README.md");
}

/// The scene file that the README has its readers save.
std::string first_scene() {
    const std::string text = readme();
    const std::size_t start = text.find("    [entities.chair]"), end = text.find("Saved as `first.toml`");
    EXPECT_TRUE(start < end && end != std::string::npos);
    return text.substr(start, end - start);
}

TEST(Readme, FirstSceneCanBeRead) {
    const TestFolder folder;
    std::filesystem::create_directory_symlink(std::filesystem::path(HAARFIELD_SOURCE_DIR) / "scenes",
                                              folder / "scenes");
    write_text(folder / "first.toml", first_scene());
    const Result<Scene> scene = read_scene(folder / "first.toml");
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->instances.size(), 1u);
}

/// A scene with few vertices and samples, and a small picture.
std::string made_small(std::string text) {
    text = std::regex_replace(text, std::regex("\n *resolution = [^\n]*"), "");
    text = std::regex_replace(
        text, std::regex("\n *(fine_vertices|planar_samples|spherical_samples) = [^\n]*"), "");
    const std::regex camera("(\n *\\[camera\\]\n)");
    text = std::regex_search(text, camera) ? std::regex_replace(text, camera, "$1resolution = [80, 60]\n")
                                           : "[camera]\nresolution = [80, 60]\n" + text;
    return std::regex_replace(text, std::regex("(\\[entities\\.[a-z]+\\]\n)"),
                              "$1fine_vertices = 2000\nplanar_samples = 1000\nspherical_samples = 1000\n");
}

/// Every line of the code blocks that runs the program, as it stands there, in a folder where the project's
/// scenes are small.
TEST(Readme, CommandsDoWhatTheySay) {
    const TestFolder folder;
    const std::filesystem::path source = HAARFIELD_SOURCE_DIR;
    std::filesystem::create_directories(folder / "build/release");
    std::filesystem::create_symlink(HAARFIELD_PROGRAM, folder / "build/release/haarfield");
    std::filesystem::create_directory(folder / "scenes");
    std::filesystem::create_directory_symlink(source / "scenes/meshes", folder / "scenes/meshes");
    for (const auto& entry : std::filesystem::directory_iterator(source / "scenes"))
        if (entry.path().extension() == ".toml")
            write_text(folder / "scenes" / entry.path().filename(), made_small(text_of(entry.path())));

    std::set<std::string> commands;
    const std::string text = readme();
    const std::regex line("\n    build/release/haarfield (\\w+) [^\n]*");
    for (std::sregex_iterator match(text.begin(), text.end(), line), end; match != end; ++match) {
        commands.insert((*match)[1]);
        if ((*match)[1] == "view")
            continue;  // serves until it is interrupted: view/test_view_page.py runs it
        const std::string command = match->str().substr(5);
        EXPECT_EQ(std::system(("cd '" + folder.path().string() + "' && " + command + " > said 2>&1").c_str()),
                  0)
            << command << '\n'
            << text_of(folder / "said");
        if ((*match)[1] == "import")
            write_text(folder / "out/first/chair.toml", made_small(text_of(folder / "out/first/chair.toml")));
    }
    EXPECT_EQ(commands, (std::set<std::string>{"bake", "compare", "import", "reference", "relight", "view"}));
    for (const char* file :
         {"baked.png", "baked.exr", "chair.pov", "chair_Chair.inc", "chair.ply", "report.html"})
        EXPECT_TRUE(std::filesystem::is_regular_file(folder / "out/first" / file)) << file;
    EXPECT_TRUE(std::filesystem::is_directory(folder / "out/first/fields"));
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "out/spin/frame_0024.png"));
}

/// What `haarfield COMMAND --help` says.
std::string help_of(const std::string& command) {
    const TestFolder folder;
    const std::string file = (folder / "help").string();
    EXPECT_EQ(std::system((std::string(HAARFIELD_PROGRAM) + " " + command + " --help > " + file).c_str()), 0);
    return text_of(file);
}

/// The options that a text names in code, each once.
std::set<std::string> options_in(const std::string& text) {
    std::set<std::string> options;
    const std::regex option("[ `](--[a-z][a-z-]+)");
    for (std::sregex_iterator match(text.begin(), text.end(), option), end; match != end; ++match)
        options.insert((*match)[1]);
    return options;
}

bool has_option(const std::string& help, const std::string& option) {
    return std::regex_search(help, std::regex(option + "(?![a-z-])"));
}

TEST(Readme, CommandsHaveTheOptionsThatTheirRowsName) {
    const std::string text = readme();
    std::set<std::string> commands;
    // | `info FIELD.vdb`, `verify FIELD.vdb` | what they do |
    const std::regex row("\n\\| ((?:(?:, )?`[a-z]+ [A-Z][^`|]*`)+) \\| ([^\n]*)"), name("`([a-z]+) ");
    for (std::sregex_iterator match(text.begin(), text.end(), row), end; match != end; ++match) {
        const std::string first = (*match)[1], what = (*match)[2];
        for (std::sregex_iterator named(first.begin(), first.end(), name); named != end; ++named) {
            commands.insert((*named)[1]);
            const std::string help = help_of((*named)[1]);
            for (const std::string& option : options_in(what))
                EXPECT_TRUE(has_option(help, option)) << (*named)[1] << " has no " << option;
        }
    }
    EXPECT_EQ(commands, (std::set<std::string>{"bake", "budget", "compare", "import", "info", "join",
                                               "library", "plan", "precompute", "reference", "relight",
                                               "residual", "status", "verify", "view", "work"}));
}

/// Outside of these rows and of the code blocks, by the commands that the text means.
TEST(Readme, NamesNoOptionThatItsCommandsLack) {
    const std::set<std::string> all{"bake",    "budget", "compare",    "import",    "info",    "join",
                                    "library", "plan",   "precompute", "reference", "relight", "residual",
                                    "status",  "verify", "view",       "work"},
        make_fields{"bake", "budget", "precompute", "relight"};
    const std::map<std::string, std::set<std::string>> meant{
        {"--help", all},
        {"--report", all},
        {"--quiet", all},
        {"--unsandboxed", all},
        {"--frame", {"bake", "budget", "reference", "relight"}},
        {"--visibility-error", make_fields},
        {"--allow-unsealed", {"bake", "budget", "precompute", "relight", "info", "verify"}},
        {"--occlusion", {"bake", "relight"}},
        {"--occlusion-error", {"bake"}},
        {"--reach", {"bake", "relight"}},
        {"--refine", {"bake"}},
        {"--floor", {"import"}},
        {"--format", {"bake", "relight"}},
        {"--colours", {"bake"}},
        {"--vertex-budget", {"bake"}},
        {"--spin-light", {"relight"}},
        {"--orbit", {"relight"}},
        {"--move", {"relight"}},
        {"--keyframes", {"relight"}},
        {"--fields", make_fields},
        {"--bounces", {"bake", "budget", "reference", "relight", "view"}},
        {"--lights", {"reference"}},
        {"--relative-error", {"reference"}},
        {"--listen", {"view"}},
        {"--hook", {"plan"}},
        {"--tasks", {"plan", "work"}},
        {"--verify", {"library", "status"}},
        {"--instructions", {"plan"}},
        {"--povray-patience", {"bake", "reference"}},
        {"--pruning-error", {"relight"}}};
    std::map<std::string, std::string> help;
    for (const std::string& command : all) help[command] = help_of(command);

    std::string text = std::regex_replace(readme(), std::regex("\n    [^\n]*"), "");
    text = std::regex_replace(text, std::regex("\n\\| `[a-z]+ [A-Z][^\n]*"), "");
    text = std::regex_replace(text, std::regex("`cmake [^`]*`"), "");
    std::set<std::string> named = options_in(text);
    for (const auto& [option, commands] : meant) {
        EXPECT_EQ(named.erase(option), 1u) << option << " is named no more";
        for (const std::string& command : commands)
            EXPECT_TRUE(has_option(help.at(command), option)) << command << " has no " << option;
    }
    const std::string scripts =
        text_of(std::filesystem::path(HAARFIELD_SOURCE_DIR) / "tools/farm/plan_scripts.cpp");
    for (const char* option : {"--tasks-per-job", "--at-once", "--most-jobs"}) {
        EXPECT_EQ(named.erase(option), 1u) << option << " is named no more";
        EXPECT_NE(scripts.find(std::string(option) + "=*)"), std::string::npos) << option;
    }
    EXPECT_EQ(named.erase("--mem"), 1u) << "of sbatch";
    EXPECT_NE(scripts.find("--mem="), std::string::npos);
    for (const std::string& option : named) ADD_FAILURE() << "whose option is " << option << '?';
}

TEST(Readme, NamesOnlyFilesThatThereAre) {
    const std::string text = readme();
    const std::regex file("((?:fields|shading|scenes|bridge|tools|tests)/[a-z0-9_/]+(?:\\.[a-z]+)?)");
    int count = 0;
    for (std::sregex_iterator match(text.begin(), text.end(), file), end; match != end; ++match, ++count)
        EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(HAARFIELD_SOURCE_DIR) / (*match)[1].str()))
            << (*match)[1];
    EXPECT_GE(count, 15);
}

}  // namespace
}  // namespace haarfield
