#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "scenes/scene_reader.h"
#include "scenes/scene_writer.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

const std::filesystem::path source = HAARFIELD_SOURCE_DIR;

/// The README and the pages that it links to for users.
const std::vector<std::string> pages{"README.md",
                                     "scenes/SCENE_FILE.md",
                                     "tools/README.md",
                                     "tools/farm/README.md",
                                     "tools/python/README.md",
                                     "tools/blender/README.md",
                                     "tools/view/README.md",
                                     "bridge/README.md",
                                     "fields/field/README.md",
                                     "tests/bench/RESULTS.md",
                                     "shading/PAPER.md"};

/// Pages whose commands run as they are written.
const std::vector<std::string> pages_with_commands{"README.md", "scenes/SCENE_FILE.md", "tools/README.md",
                                                   "tools/farm/README.md", "tools/view/README.md"};

std::string page(const std::string& name) {
    return text_of(source / name);
}

/// Returns the text of all pages.
std::string all_pages() {
    std::string text;
    for (const std::string& name : pages) text += "\n" + page(name);
    return text;
}

/// Returns the scene file that readers of the page on scene files are asked to save.
std::string first_scene() {
    const std::string text = page("scenes/SCENE_FILE.md");
    const std::size_t start = text.find("    [entities.chair]"), end = text.find("Save this as `first.toml`");
    EXPECT_TRUE(start < end && end != std::string::npos);
    return text.substr(start, end - start);
}

TEST(Readme, IsShort) {
    std::istringstream text(page("README.md"));
    const auto words = std::distance(std::istream_iterator<std::string>(text), {});
    EXPECT_GE(words, 600);
    EXPECT_LE(words, 900);
}

TEST(Readme, FirstSceneCanBeRead) {
    const TestFolder folder;
    std::filesystem::create_directory_symlink(source / "scenes", folder / "scenes");
    write_text(folder / "first.toml", first_scene());
    const Result<Scene> scene = read_scene(folder / "first.toml");
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->instances.size(), 1u);
}

/// A row of a table of keys on the page of scene files.
struct KeyRow {
    std::string section;  ///< As in its heading: `[camera]`, `sky`.
    std::string keys;     ///< The first cell.
    std::string value;    ///< The default, if it is TOML; else empty.
};

/// Returns the names in backticks in a text.
std::vector<std::string> names_in(const std::string& text) {
    std::vector<std::string> names;
    const std::regex name("`([a-z_]+)`");
    for (std::sregex_iterator match(text.begin(), text.end(), name), end; match != end; ++match)
        names.push_back((*match)[1]);
    return names;
}

std::vector<KeyRow> key_rows() {
    std::vector<KeyRow> rows;
    std::string section;
    const std::regex heading("##+ `(.*)`|The table `(pigment)` has .*"),
        row("\\| (`[a-z_]+`.*?) \\| (?:`([^`]*)`|[^|]*) \\| .*");
    std::istringstream text(page("scenes/SCENE_FILE.md"));
    std::smatch match;
    for (std::string line; std::getline(text, line);) {
        if (std::regex_match(line, match, heading))
            section = match[1].str() + match[2].str();
        else if (std::regex_match(line, match, row))
            rows.push_back({section, match[1], match[2]});
    }
    return rows;
}

TEST(Readme, ScenePageHasTheKeysThatScenesHave) {
    std::set<std::string> documented, read;
    for (const KeyRow& row : key_rows())
        for (const std::string& key : names_in(row.keys)) documented.insert(key);
    for (const char* root : {"camera", "environment", "materials", "entities", "instances", "lights",
                             "keyframes", "filters", "povray", "bounces", "assumed_gamma"})
        documented.insert(root);
    const std::regex key("\\btake\\w*(?:<[^>]*>)?\\((?:\\w+, )?\"(\\w+)\"");
    for (const char* file : {"scenes/scene_reader.cpp", "scenes/lamp_reader.cpp", "scenes/povray_finish.h"}) {
        const std::string text = page(file);
        for (std::sregex_iterator match(text.begin(), text.end(), key), end; match != end; ++match)
            read.insert((*match)[1]);
    }
    EXPECT_GT(read.size(), 60u);
    EXPECT_EQ(documented, read);
}

/// Returns a scene with every table. `line` is added to the table of a section.
std::string scene_with(const std::string& section, const std::string& key, const std::string& line) {
    const auto added = [&](const char* name) { return section == name ? line + "\n" : std::string(); };
    const std::string spot = key == "kind" ? "" : "kind = \"spot\"\ntarget = [0, 0, 0]\n";
    return "[camera]\nposition = [0, 1, 5]\ntarget = [0, 0, 0]\n" + added("[camera]") +  //
           "[environment]\n" + added("[environment]") +                                  //
           "[environment.sky]\n" + added("sky") +                                        //
           "[materials.plain]\n" + added("[materials.NAME]") +                           //
           "[materials.povray]\npigment = [0.5, 0.5, 0.5]\n" +                           //
           "[materials.povray.finish]\n" + added("finish") +                             //
           "[materials.oak.pigment]\nimage = \"oak.png\"\n" + added("pigment") +         //
           "[entities.box]\nmesh = \"box.obj\"\n" + added("[entities.NAME]") +           //
           "[povray]\nscene = \"room.pov\"\n" + added("[povray]") +                      //
           "[[instances]]\nentity = \"box\"\n" + added("[[instances]]") +                //
           "[[lights]]\nposition = [0, 2, 0]\n" + spot + added("[[lights]]") +           //
           "[lights.area]\nacross = [1, 0, 0]\nalong = [0, 0, 1]\n" + added("area");
}

TEST(Readme, ScenePageHasTheDefaultsThatScenesHave) {
    const TestFolder folder;
    for (const char* file : {"oak.png", "box.obj", "room.pov"}) write_text(folder / file, "");
    const auto text = [&](const KeyRow& row, const std::string& key, const std::string& line) {
        write_text(folder / "scene.toml", scene_with(row.section, key, line));
        const Result<Scene> scene = read_scene(folder / "scene.toml");
        EXPECT_TRUE(scene) << key << ": " << scene.error().message();
        return scene ? scene_text(*scene, folder.path()) : std::string();
    };
    int count = 0;
    for (const KeyRow& row : key_rows()) {
        const std::string key = names_in(row.keys).front();
        if (row.value.empty()) continue;
        EXPECT_EQ(text(row, key, key + " = " + row.value), text(row, key, "")) << row.section;
        ++count;
    }
    EXPECT_GT(count, 35);
}

/// Reduces the vertices, samples and pixels of a scene.
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

/// Runs every line of the code blocks that runs the program, as it is written, in a folder where the
/// project's scenes are small.
TEST(Readme, CommandsDoWhatTheySay) {
    const TestFolder folder;
    std::filesystem::create_directories(folder / "build/release");
    std::filesystem::create_symlink(HAARFIELD_PROGRAM, folder / "build/release/haarfield");
    std::filesystem::create_directory(folder / "scenes");
    std::filesystem::create_directory_symlink(source / "scenes/meshes", folder / "scenes/meshes");
    for (const auto& entry : std::filesystem::directory_iterator(source / "scenes"))
        if (entry.path().extension() == ".toml")
            write_text(folder / "scenes" / entry.path().filename(), made_small(text_of(entry.path())));
    write_text(folder / "first.toml",
               made_small(std::regex_replace(first_scene(), std::regex("\n    "), "\n")));

    std::set<std::string> commands;
    const std::regex line("\n    build/release/haarfield (\\w+) [^\n]*");
    for (const std::string& name : pages_with_commands) {
        const std::string text = page(name);
        for (std::sregex_iterator match(text.begin(), text.end(), line), end; match != end; ++match) {
            commands.insert((*match)[1]);
            if ((*match)[1] == "view")
                continue;  // serves until it is interrupted: view/test_view_page.py runs it
            const std::string command = match->str().substr(5);
            EXPECT_EQ(
                std::system(("cd '" + folder.path().string() + "' && " + command + " > said 2>&1").c_str()),
                0)
                << command << '\n'
                << text_of(folder / "said");
            if ((*match)[1] == "import")
                write_text(folder / "out/first/chair.toml",
                           made_small(text_of(folder / "out/first/chair.toml")));
        }
    }
    EXPECT_EQ(commands, (std::set<std::string>{"bake", "compare", "import", "plan", "reference", "relight",
                                               "status", "view"}));
    for (const char* file :
         {"baked.png", "baked.exr", "chair.pov", "chair_Chair.inc", "chair.ply", "report.html"})
        EXPECT_TRUE(std::filesystem::is_regular_file(folder / "out/first" / file)) << file;
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "out/lacquer/baked.png"));
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "out/spin/frame_0024.png"));
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "out/plan/slurm.sh"));
}

/// Returns what `haarfield COMMAND --help` prints.
std::string help_of(const std::string& command) {
    const TestFolder folder;
    const std::string file = (folder / "help").string();
    EXPECT_EQ(std::system((std::string(HAARFIELD_PROGRAM) + " " + command + " --help > " + file).c_str()), 0);
    return text_of(file);
}

/// Returns the options that a text names in code, each once.
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
    const std::string text = page("README.md") + page("tools/README.md");
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
                                               "library", "plan", "precompute", "probe", "reference",
                                               "relight", "residual", "status", "verify", "view", "work"}));
}

/// Checks the options that pages name outside of tables of commands and code blocks.
TEST(Readme, NamesNoOptionThatItsCommandsLack) {
    const std::set<std::string> all{"bake",     "budget", "compare",    "import", "info",      "join",
                                    "library",  "plan",   "precompute", "probe",  "reference", "relight",
                                    "residual", "status", "verify",     "view",   "work"},
        make_fields{"bake", "budget", "precompute", "relight"};
    const std::map<std::string, std::set<std::string>> meant{
        {"--help", all},
        {"--report", all},
        {"--quiet", all},
        {"--unsandboxed", all},
        {"--threads", all},
        {"--depth", {"bake"}},
        {"--evaluator", {"bake"}},
        {"--samples", {"bake", "budget"}},
        {"--pass", {"bake"}},
        {"--original-vertices", {"bake", "precompute"}},
        {"--radiosity", {"reference"}},
        {"--rotate", {"relight"}},
        {"--movie", {"relight"}},
        {"--json", {"info", "library", "status"}},
        {"--dry-run", {"library"}},
        {"--unused-for", {"library"}},
        {"--shrink-to", {"library"}},
        {"--task-seconds", {"plan"}},
        {"--frame", {"bake", "budget", "reference", "relight"}},
        {"--visibility-error", make_fields},
        {"--occlusion", {"bake", "relight"}},
        {"--occlusion-error", {"bake"}},
        {"--reach", {"bake", "relight"}},
        {"--error", {"bake"}},
        {"--everywhere", {"bake"}},
        {"--worst", {"bake"}},
        {"--face-size", {"bake"}},
        {"--refine", {"bake"}},
        {"--format", {"bake", "relight"}},
        {"--colours", {"bake"}},
        {"--vertex-budget", {"bake"}},
        {"--spin-light", {"relight"}},
        {"--orbit", {"relight"}},
        {"--move", {"relight"}},
        {"--keyframes", {"relight"}},
        {"--fields", make_fields},
        {"--bounces", {"bake", "budget", "reference", "relight", "view"}},
        {"--lights", {"reference", "view"}},
        {"--relative-error", {"reference"}},
        {"--listen", {"view"}},
        {"--hook", {"plan"}},
        {"--tasks", {"plan", "work"}},
        {"--verify", {"library", "status"}},
        {"--instructions", {"plan"}},
        {"--povray-patience", {"bake", "reference"}},
        {"--detail", {"import"}},
        {"--object", {"import"}},
        {"--object-seconds", {"import"}},
        {"--at", {"import", "probe"}},
        {"--into", {"import"}},
        {"--unit", {"import"}},
        {"--scale-to", {"import"}},
        {"--without", {"probe"}},
        {"--pruning-error", {"relight"}}};
    std::map<std::string, std::string> help;
    for (const std::string& command : all) help[command] = help_of(command);

    std::string text = std::regex_replace(all_pages(), std::regex("\n    [^\n]*"), "");
    text = std::regex_replace(text, std::regex("\n\\| `[a-z]+ [A-Z][^\n]*"), "");
    text = std::regex_replace(text, std::regex("`(?:cmake|tools/)[^`]*`"), "");
    std::set<std::string> named = options_in(text);
    for (const auto& [option, commands] : meant) {
        EXPECT_EQ(named.erase(option), 1u) << option << " is named no more";
        for (const std::string& command : commands)
            EXPECT_TRUE(has_option(help.at(command), option)) << command << " has no " << option;
    }
    const std::string scripts = page("tools/farm/plan_scripts.cpp");
    for (const char* option : {"--tasks-per-job", "--at-once", "--most-jobs"}) {
        EXPECT_EQ(named.erase(option), 1u) << option << " is named no more";
        EXPECT_NE(scripts.find(std::string(option) + "=*)"), std::string::npos) << option;
    }
    EXPECT_EQ(named.erase("--mem"), 1u) << "of sbatch";
    EXPECT_NE(scripts.find("--mem="), std::string::npos);
    for (const std::string& option : named) ADD_FAILURE() << "whose option is " << option << '?';
}

TEST(Readme, PagesNameOnlyFilesThatExist) {
    const std::regex file("((?:fields|shading|scenes|bridge|tools|tests)/[a-z0-9_/-]+(?:\\.[a-z]+)?)"),
        link("\\]\\(([^)#]+)\\)");
    int count = 0;
    for (const std::string& name : pages) {
        const std::string text = page(name);
        const std::filesystem::path folder = (source / name).parent_path();
        for (std::sregex_iterator match(text.begin(), text.end(), file), end; match != end; ++match, ++count)
            EXPECT_TRUE(exists(source / (*match)[1].str()) || exists(folder / (*match)[1].str()))
                << name << ": " << (*match)[1];
        for (std::sregex_iterator match(text.begin(), text.end(), link), end; match != end; ++match, ++count)
            EXPECT_TRUE(exists(folder / (*match)[1].str())) << name << ": " << (*match)[1];
    }
    EXPECT_GE(count, 60);
}

/// Returns the names of all tests, `Suite.Test`, from their sources.
std::set<std::string> test_names() {
    std::set<std::string> names;
    const std::regex test("\nTEST(?:_F|_P)?\\((\\w+), (\\w+)\\)");
    for (const auto& entry : std::filesystem::directory_iterator(source / "tests")) {
        if (entry.path().extension() != ".cpp") continue;
        const std::string text = text_of(entry.path());
        for (std::sregex_iterator match(text.begin(), text.end(), test), end; match != end; ++match)
            names.insert((*match)[1].str() + "." + (*match)[2].str());
    }
    return names;
}

TEST(Readme, PaperPageNamesOnlyTestsThatExist) {
    const std::string text = page("shading/PAPER.md");
    const std::set<std::string> names = test_names();
    const std::regex name("`([A-Z]\\w+\\.[A-Z]\\w+)`");
    int count = 0;
    for (std::sregex_iterator match(text.begin(), text.end(), name), end; match != end; ++match, ++count)
        EXPECT_TRUE(names.contains((*match)[1])) << (*match)[1];
    EXPECT_GE(count, 40);
}

/// Returns a header without its comments.
std::string code_of(const std::string& file) {
    return std::regex_replace(page(file), std::regex("//[^\n]*"), "");
}

bool declares(const std::string& code, const std::string& name) {
    return std::regex_search(code, std::regex("\\b" + name + "\\b"));
}

/// Rows of the manuals' tables: | declaration, declaration | header | purpose |
TEST(Readme, ManualsNameOnlyHeadersAndDeclarationsThatExist) {
    const std::regex header("[a-z_]+/[a-z_/]+\\.(?:h|md)"), name("\\w+"),
        row("/// \\| (\\w+(?:, \\w+)*) \\| ([a-z_/]+\\.h) \\| [^|\n]* \\|\n"), arrow("--(\\w+)-->");
    std::string headers;  // of this manual and of those before
    for (const char* library : {"fields", "shading", "scenes", "bridge"}) {
        const std::string manual = page(std::string(library) + "/" + library + ".h"),
                          prose = manual.substr(0, manual.find("```cpp"));
        for (std::sregex_iterator match(prose.begin(), prose.end(), header), end; match != end; ++match)
            EXPECT_TRUE(exists(source / match->str())) << library << ": " << match->str();
        std::set<std::string> declared;
        for (std::sregex_iterator match(prose.begin(), prose.end(), row), end; match != end; ++match) {
            const std::string names = (*match)[1], code = code_of((*match)[2]);
            headers += code;
            for (std::sregex_iterator one(names.begin(), names.end(), name); one != end; ++one) {
                EXPECT_TRUE(declares(code, one->str())) << library << ": " << match->str();
                declared.insert(one->str());
            }
        }
        EXPECT_GE(declared.size(), 12u) << library;
        // The functions of the data flow are in these headers.
        for (std::sregex_iterator match(prose.begin(), prose.end(), arrow), end; match != end; ++match)
            EXPECT_TRUE(declares(headers, (*match)[1])) << library << ": " << (*match)[1];
    }
}

TEST(Readme, LinksToEveryPage) {
    const std::string text = page("README.md");
    for (const std::string& name : pages)
        EXPECT_TRUE(name == "README.md" || text.find("(" + name + ")") != std::string::npos) << name;
}

}  // namespace
}  // namespace haarfield
