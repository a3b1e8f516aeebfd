#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "bridge/files/mesh_file.h"
#include "fields/base/sanitizers.h"
#include "fields/model/polygon_file.h"
#include "tests/fixtures/library_files.h"
#include "tools/command.h"

extern char** environ;

namespace {

constexpr const char* all_commands[] = {"import",  "precompute", "bake",   "reference", "compare",  "budget",
                                        "relight", "info",       "verify", "library",   "residual", "probe",
                                        "plan",    "work",       "join",   "status",    "view"};

std::string text_of(const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

/// Removes what ThreadSanitizer prints if it does not find the symbols of a library.
std::string without_symbolizer(const std::string& text) {
    if (!haarfield::is_thread_sanitized) return text;
    return std::regex_replace(text, std::regex("LLVMSymbolizer: [^\n]*\n"), "");
}

struct Outcome {
    int code = -1;  // exit code; -signal if ended by one
    std::string out, err;
};

/// Runs the program in a temporary folder.
class Commands : public testing::Test {
protected:
    void SetUp() override {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ =
            std::filesystem::path(testing::TempDir()) / fmt::format("commands_{}_{}", test->name(), getpid());
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    pid_t start(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), HAARFIELD_PROGRAM);
        std::vector<char*> pointers;
        for (std::string& argument : arguments) pointers.push_back(argument.data());
        pointers.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addchdir_np(&actions, folder_.c_str());
        constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC;
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "stdout.txt", flags, 0600);
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "stderr.txt", flags, 0600);
        pid_t child = -1;
        const int failure =
            posix_spawn(&child, HAARFIELD_PROGRAM, &actions, nullptr, pointers.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        // An invalid process number must not be returned: a signal to -1 would reach all processes.
        if (failure != 0 || child <= 0) throw std::runtime_error(HAARFIELD_PROGRAM " can not be run");
        return child;
    }

    Outcome finish(pid_t child) {
        int status = 0;
        waitpid(child, &status, 0);
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), text_of(folder_ / "stdout.txt"),
                without_symbolizer(text_of(folder_ / "stderr.txt"))};
    }

    Outcome run(std::vector<std::string> arguments) { return finish(start(std::move(arguments))); }

    nlohmann::json report(const char* name) {
        return nlohmann::json::parse(text_of(folder_ / name), nullptr, false);
    }

    /// Writes a scene with a box on a floor under a sky, which bakes within seconds.
    void write_scene(int fine_vertices = 300) {
        std::ofstream(folder_ / "box.obj")
            << "v -0.5 0 -0.5\nv 0.5 0 -0.5\nv 0.5 0 0.5\nv -0.5 0 0.5\n"
               "v -0.5 1 -0.5\nv 0.5 1 -0.5\nv 0.5 1 0.5\nv -0.5 1 0.5\n"
               "f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";
        std::ofstream(folder_ / "floor.obj") << "v -3 0 -3\nv 3 0 -3\nv 3 0 3\nv -3 0 3\nf 4 3 2 1\n";
        std::ofstream(folder_ / "room.toml") << fmt::format(R"(
[camera]
position = [2.5, 2, 3]
target = [0, 0.4, 0]
vertical_fov = 40
resolution = [64, 48]
[environment]
sky = {{ turbidity = 6, sun_elevation = 50, sun_azimuth = 20, sun_angular_radius = 5 }}
[materials.clay]
diffuse = [0.6, 0.5, 0.4]
convention = "povray"
[entities.box]
mesh = "box.obj"
material = "clay"
fine_vertices = {0}
coarse_triangles = 0
planar_samples = 60
spherical_samples = 60
[entities.floor]
mesh = "floor.obj"
material = "clay"
fine_vertices = 2000
coarse_triangles = 0
planar_samples = 20
spherical_samples = 20
[[instances]]
entity = "floor"
[[instances]]
entity = "box"
translate = [0, 0.001, 0]
)",
                                                            fine_vertices);
    }

    std::filesystem::path folder_;
};

TEST_F(Commands, HelpShowsEveryCommandWithAnExample) {
    const Outcome help = run({"--help"});
    EXPECT_EQ(help.code, 0);
    for (const char* command : all_commands) {
        EXPECT_NE(help.out.find(command), std::string::npos) << command;
        const Outcome own = run({command, "--help"});
        EXPECT_EQ(own.code, 0) << command;
        EXPECT_EQ(own.err, "") << command;
        for (const char* part : {"Example:", "--threads", "--quiet", "--report"})
            EXPECT_NE(own.out.find(part), std::string::npos) << command << " " << part;
        EXPECT_NE(own.out.find(fmt::format("  haarfield {} ", command)), std::string::npos) << own.out;
    }
    EXPECT_EQ(run({"--version"}).out.substr(0, 10), "haarfield ");
}

TEST_F(Commands, BadUsageExitsWithTwo) {
    write_scene();
    using Arguments = std::vector<std::string>;
    for (const Arguments& arguments : {Arguments{},
                                       {"polish"},
                                       {"bake"},
                                       {"bake", "room.toml"},
                                       {"bake", "room.toml", "-o"},
                                       {"bake", "room.toml", "-o", "out", "--shiny"},
                                       {"bake", "room.toml", "room.toml", "-o", "out"},
                                       {"bake", "room.toml", "-o", "out", "--threads", "0"},
                                       {"bake", "room.toml", "-o", "out", "--threads", "two"},
                                       {"bake", "room.toml", "-o", "out", "--face-size", "48"},
                                       {"bake", "room.toml", "-o", "out", "--depth", "-1"},
                                       {"bake", "room.toml", "-o", "out", "--evaluator", "magic"},
                                       {"bake", "room.toml", "-o", "out", "--colours", "loud"},
                                       {"bake", "room.toml", "-o", "out", "--format", "fbx"},
                                       {"bake", "room.toml", "-o", "out", "--format", ""},
                                       {"bake", "room.toml", "-o", "out", "--refine", "0"},
                                       {"bake", "room.toml", "-o", "out", "--occlusion", "magic"},
                                       {"bake", "room.toml", "-o", "out", "--occlusion-error", "nan"},
                                       {"bake", "room.toml", "-o", "out", "--view", "1,2"},
                                       {"bake", "room.toml", "-o", "out", "--view", "1,nan,2"},
                                       {"bake", "room.toml", "-o", "out", "--view", "1,1,2", "--frame"},
                                       {"bake", "room.toml", "-o", "out", "--exposure", "automatic"},
                                       {"reference", "room.toml", "-o", "out", "--lights", "0"},
                                       {"compare", "a.exr", "-o", "out"},
                                       {"compare", "a.exr", "b.exr", "-o", "out", "--min-psnr", "much"},
                                       {"info"},
                                       {"work", "plan"},
                                       {"work", "plan", "--tasks", "4-"},
                                       {"work", "plan", "--task", "-1"},
                                       {"work", "plan", "--tasks", "1,,2"},
                                       {"verify", "a.vdb", "b.vdb"}}) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 2) << fmt::format("{}", fmt::join(arguments, " "));
        EXPECT_EQ(outcome.out, "") << fmt::format("{}", fmt::join(arguments, " "));
        EXPECT_NE(outcome.err, "") << fmt::format("{}", fmt::join(arguments, " "));
    }
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

/// An option that takes a number, as --help shows it.
struct NumberOption {
    std::string name, type;
    std::string wanted;  // `in [lowest, highest]`, or `{one,of,these}`
    bool is_list() const { return type.find(',') != std::string::npos; }
};

/// Returns the options of a command that accept a value other than a text, by the type names of texts.
std::vector<NumberOption> number_options(const std::string& help) {
    const std::set<std::string> texts{"DIR",     "FILE",     "FILE.json", "FILE.mp4", "TEXT",
                                      "A,B,...", "INSTANCE", "TIME",      "SIZE",     "PLAN",
                                      "SET",     "ADDRESS",  "LINE",      "NAME"};
    const std::regex line(R"(\n +(?:-\w,)?(--[a-z-]+) ([^\s:=]+)(?::(in [\[(].*?[\])]|\{.*?\}))?)");
    std::vector<NumberOption> options;
    for (std::sregex_iterator match(help.begin(), help.end(), line), end; match != end; ++match)
        if (!texts.contains((*match)[2]) &&
            (*match)[2] != "Excludes")  // a flag that excludes others has no value
            options.push_back({(*match)[1], (*match)[2], (*match)[3]});
    return options;
}

/// Parses a command line without running it. Returns the exit code and the message if it is invalid.
Outcome parsed(std::vector<std::string> arguments) {
    CLI::App program{"", "haarfield"};
    program.require_subcommand(1);
    haarfield::CommonOptions common;
    const std::vector<haarfield::Command> commands = haarfield::all_commands(program, common);
    std::ranges::reverse(arguments);
    std::ostringstream out, err;
    Outcome outcome{0, "", ""};
    try {
        program.parse(std::move(arguments));
    } catch (const CLI::ParseError& error) {
        const bool is_wrong = program.exit(error, out, err) != 0;
        outcome = {is_wrong ? 2 : 0, out.str(), err.str()};
    }
    return outcome;
}

TEST_F(Commands, EveryNumberIsRefusedUnlessItIsInItsRange) {
    EXPECT_EQ(run({"info", "missing", "--threads=nan"}).err,
              parsed({"info", "missing", "--threads=nan"}).err);
    std::set<std::pair<std::string, std::string>> tried;  // options with their ranges
    for (const std::string command : all_commands) {
        const std::string help = parsed({command, "--help"}).out;
        std::vector<std::string> arguments{command, "missing"};
        if (command == "compare") arguments.push_back("missing");
        if (command == "relight") arguments.push_back("--spin-light");
        if (help.find("--output") != std::string::npos) arguments.insert(arguments.end(), {"-o", "out"});
        const std::vector<NumberOption> options = number_options(help);
        EXPECT_FALSE(options.empty()) << help;  // --threads at least
        for (const NumberOption& option : options) {
            ASSERT_NE(option.wanted, "")
                << command << ' ' << option.name << " is not checked, or a text of a type " << option.type
                << " that this test should know";
            const auto run_with = [&](const std::string& value) {
                std::vector<std::string> all = arguments;
                if (command == "work") all.push_back("--task=0");
                if (command == "probe" && option.name != "--at") all.push_back("--at=0,0,0");
                if (command == "import" && option.name == "--at") all.push_back("--into=missing");
                if (option.name == "--batch-tasks") all.push_back("--batches=1");
                all.push_back(option.name + "=" +
                              (option.is_list() && option.wanted.starts_with("in ") ? "1,1," : "") + value);
                return parsed(all);
            };
            const auto expect_refused = [&](const std::string& value) {
                const Outcome outcome = run_with(value);
                EXPECT_EQ(outcome.code, 2) << command << ' ' << option.name << ' ' << value;
                for (const std::string& part : {option.name, value, option.wanted})
                    EXPECT_NE(outcome.err.find(part), std::string::npos) << value << ": " << outcome.err;
            };
            expect_refused("nan");
            if (!tried.emplace(option.name, option.wanted).second) continue;
            expect_refused("1x");
            const std::regex interval(R"(in ([\[(])(\S+), (\S+)([\])]))");
            std::smatch ends;
            if (!std::regex_match(option.wanted, ends, interval)) continue;
            expect_refused(fmt::format("{}", std::stoll(ends[2]) - 1));
            expect_refused(fmt::format("{}", std::stoll(ends[3]) + 1));
            for (const auto& [end, is_in] : {std::pair(ends[2], ends[1] == "["), {ends[3], ends[4] == "]"}})
                EXPECT_EQ(run_with(end).code, is_in ? 0 : 2) << command << ' ' << option.name << ' ' << end;
        }
    }
    EXPECT_GE(tried.size(), 20u);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST_F(Commands, WholeNumbersHaveNoFractions) {
    for (const char* value : {"1.5", "2.0", "1e1"}) {
        const Outcome outcome = run({"info", "missing", std::string("--threads=") + value});
        EXPECT_EQ(outcome.code, 2) << value;
        EXPECT_NE(
            outcome.err.find(fmt::format("--threads: is {}; expected a whole number in [1, 1024]", value)),
            std::string::npos)
            << outcome.err;
    }
}

TEST_F(Commands, NumbersThatRoundToAnExcludedEndAreRefused) {
    EXPECT_EQ(run({"bake", "missing", "-o", "out", "--visibility-error", "0.9999"}).code, 1);
    EXPECT_EQ(run({"bake", "missing", "-o", "out", "--visibility-error", "0.9999999999"}).code, 2);
}

TEST_F(Commands, BadInputExitsWithOneAndNamesThePlace) {
    write_scene();
    std::ofstream(folder_ / "broken.toml") << "[camera\n";
    std::ofstream(folder_ / "broken.vdb") << "no field";
    std::ofstream(folder_ / "broken.exr") << "no picture";
    using Arguments = std::vector<std::string>;
    for (const auto& [arguments, where] :
         {std::pair<Arguments, const char*>{{"precompute", "missing.toml"}, "missing.toml"},
          {{"precompute", "broken.toml"}, "broken.toml:1:"},
          {{"bake", "broken.toml", "-o", "out"}, "broken.toml:1:"},
          {{"bake", "room.toml", "-o", "out", "--environment", "broken.exr"}, "broken.exr"},
          {{"bake", "room.toml", "-o", "out", "--view", "0,0.4,0"}, "--view"},
          {{"bake", "room.toml", "-o", "out", "--evaluator", "dense", "--refine", "0.1"}, "evaluator dense"},
          {{"reference", "broken.toml", "-o", "out"}, "broken.toml:1:"},
          {{"compare", "broken.exr", "missing.exr", "-o", "out"}, "broken.exr"},
          {{"info", "broken.vdb"}, "broken.vdb"},
          {{"verify", "broken.vdb"}, "broken.vdb"},
          {{"verify", "missing.vdb"}, "missing.vdb"}}) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 1) << fmt::format("{}", fmt::join(arguments, " "));
        EXPECT_EQ(outcome.out, "") << fmt::format("{}", fmt::join(arguments, " "));
        EXPECT_NE(outcome.err.find(where), std::string::npos) << outcome.err;
    }
    EXPECT_EQ(run({"bake", "broken.toml", "-o", "out", "--report", "report.json"}).code, 1);
    EXPECT_NE(report("report.json").value("error", "").find("broken.toml:1:"), std::string::npos);
    EXPECT_EQ(report("report.json").value("exit_code", 0), 1);
}

TEST_F(Commands, ABakeAgreesWithItsReference) {
    write_scene();
    const std::vector<std::string> bake{"bake",      "room.toml", "-o",          "out",
                                        "--error",   "off",       "--face-size", "32",
                                        "--threads", "2",         "--report",    "out/baked.json"};
    const Outcome baked = run(bake);
    ASSERT_EQ(baked.code, 0) << baked.err;
    for (const char* file :
         {"baked.exr", "baked.png", "room.pov", "room_Box.inc", "room_Floor.inc", "room.ply"})
        EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "out" / file)) << file;

    const nlohmann::json made = report("out/baked.json");
    ASSERT_TRUE(made.is_object());
    EXPECT_EQ(made.value("command", ""), "bake");
    EXPECT_EQ(made.value("threads", 0), 2);
    EXPECT_EQ(made.value("exit_code", -1), 0);
    EXPECT_TRUE(made.contains("version") && made["version"].is_string());
    EXPECT_TRUE(made.contains("warnings") && made["warnings"].is_array());
    EXPECT_GE(made.value("seconds", 0.0), made.value("shade_seconds", 1e9));
    EXPECT_GE(made.value("processor_seconds", 0.0), made.value("shade_processor_seconds", 1e9));
    EXPECT_GT(made.value("shade_processor_seconds", 0.0), 0.0);
    EXPECT_GE(made.value("vertices", 0), 2300);
    ASSERT_EQ(made["fields"].size(), 2u);
    for (const nlohmann::json& field : made["fields"]) {
        EXPECT_TRUE(field["entity"] == "box" || field["entity"] == "floor");
        EXPECT_EQ(field["reused"], false);
        EXPECT_GT(field["samples"], 300);
        EXPECT_GT(field["nodes"], 0);
        EXPECT_GT(field["bytes"], 1000);
        EXPECT_GE(field["seconds"], 0.0);
    }

    // Fields are reused, and `info` describes them.
    const std::string box = haarfield::field_of(folder_ / "out/fields", "box");
    const Outcome again =
        run({"precompute", "room.toml", "-o", "out", "--face-size", "32", "--report", "again.json"});
    ASSERT_EQ(again.code, 0) << again.err;
    const nlohmann::json reuse = report("again.json");
    for (const nlohmann::json& field : reuse.at("fields")) EXPECT_EQ(field["reused"], true);
    EXPECT_EQ(run({"verify", box}).code, 0);
    const nlohmann::json info = nlohmann::json::parse(run({"info", box, "--json"}).out, nullptr, false);
    EXPECT_EQ(info.value("entity", ""), "box");
    EXPECT_EQ(info.value("face_size", 0), 32);
    EXPECT_NE(run({"info", box}).out.find("box"), std::string::npos);

    EXPECT_NE(run({"library", "out/fields"}).out.find("2 fields"), std::string::npos);
    // A damaged field is detected and recomputed.
    std::filesystem::resize_file(box, 1000);
    EXPECT_EQ(run({"verify", box}).code, 1);
    const Outcome remade = run({"precompute", "room.toml", "-o", "out", "--face-size", "32"});
    EXPECT_EQ(remade.code, 0);
    EXPECT_NE(remade.err.find("field remade"), std::string::npos) << remade.err;

    // The two renderers have only scene, light and camera in common.
    const Outcome traced = run({"reference", "room.toml", "-o", "out", "--relative-error", "0.05"});
    ASSERT_EQ(traced.code, 0) << traced.err;
    const std::vector<std::string> compare{"compare", "out/baked.exr", "out/reference.exr", "-o",
                                           "out",     "--report",      "out/compare.json",  "--min-psnr"};
    std::vector<std::string> lenient = compare, strict = compare;
    lenient.push_back("25");
    strict.push_back("98");
    const Outcome compared = run(lenient);
    EXPECT_EQ(compared.code, 0) << compared.out << compared.err;
    const nlohmann::json difference = report("out/compare.json");
    for (const char* key : {"psnr_db", "relative_rmse", "rmse", "ssim", "flip"})
        EXPECT_TRUE(difference.contains(key) && difference[key].is_number()) << key;
    EXPECT_LT(difference.value("psnr_db", 99.0), 60.0);

    // With half of the vertices, but where they are needed.
    std::vector<std::string> refine = bake;  // with another choice of vertices
    refine.insert(refine.end(), {"--refine", "0.002", "--vertex-budget", "1200", "--colours", "fitted"});
    ASSERT_EQ(run(refine).code, 0);
    const nlohmann::json refined = report("out/baked.json");
    EXPECT_LE(refined.value("vertices", 9999), 1200);
    EXPECT_GT(refined.at("refinement").value("rounds", 0), 1);
    EXPECT_EQ(run(lenient).code, 0);
    EXPECT_GT(report("out/compare.json").value("psnr_db", 0.0), difference.value("psnr_db", 99.0) - 0.3);
    EXPECT_LT(difference.value("reference_relative_error", 1.0), 0.05);
    EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "out/difference.png"));
    EXPECT_NE(text_of(folder_ / "out/report.html").find("haarfield bake room.toml"), std::string::npos);
    const Outcome refused = run(strict);
    EXPECT_EQ(refused.code, 3) << refused.err;
    EXPECT_NE(refused.err.find("PSNR"), std::string::npos);
}

TEST_F(Commands, ABudgetListsApproximationsAndChecksTheOracle) {
    write_scene();
    // The fields are in another folder than the output.
    const Outcome outcome =
        run({"budget", "room.toml", "-o", "out/said", "--fields", "out/fields", "--points", "60", "--lights",
             "256", "--light-coefficients", "20", "--report", "budget.json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const nlohmann::json made = report("budget.json");
    std::map<std::string, double> error;
    for (const auto& entry : made["budget"]) error[entry["approximation"]] = entry["relative_rmse"];
    EXPECT_EQ(error.size(), 16u);
    EXPECT_GT(error["rays"], 0);
    EXPECT_LT(error["rays"], 0.2);
    EXPECT_GT(error["no bounces"], error["bounces"]);
    EXPECT_LT(error["sources"], 0.01);
    EXPECT_GT(error["lighting"], 1e-4);
    EXPECT_LT(error["lighting"], 0.1);
    EXPECT_GT(error["interpolation"], 0);
    EXPECT_EQ(made["vertices"], 60);
    EXPECT_EQ(made["oracle"]["points"], 60);
    EXPECT_GE(made["oracle"]["agreeing"], 50);
    const std::string page = text_of(folder_ / "out/said/budget.html");
    for (const char* part :
         {"<svg", "lighting", "data:image/png", "of 60 points", "<circle", "haarfield budget"})
        EXPECT_NE(page.find(part), std::string::npos) << part;
}

TEST_F(Commands, ThePictureDoesNotDependOnTheNumberOfThreads) {
    write_scene();
    std::vector<std::string> formats;
    std::vector<std::filesystem::path> files{"room_Box.inc", "room_Floor.inc"};
    for (const haarfield::MeshFormat& format : haarfield::mesh_formats()) {
        formats.emplace_back(format.name);
        files.emplace_back("room." + formats.back());
    }
    for (const char* threads : {"1", "3"}) {
        const Outcome outcome =
            run({"bake", "-o", threads, "--error", "off", "--face-size", "16", "--no-render", "--quiet",
                 "--threads", threads, "--format", fmt::format("{}", fmt::join(formats, ",")), "room.toml"});
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.err, "");
        EXPECT_FALSE(std::filesystem::exists(folder_ / threads / "baked.exr"));
    }
    for (const char* entity : {"box", "floor"})
        files.push_back(haarfield::field_of(folder_ / "1/fields", entity).lexically_relative(folder_ / "1"));
    for (const std::filesystem::path& file : files)
        EXPECT_TRUE(text_of(folder_ / "1" / file) == text_of(folder_ / "3" / file) &&
                    !text_of(folder_ / "1" / file).empty())
            << file;
}

TEST_F(Commands, ABakeReachesAndReportsTheErrorThatIsAskedFor) {
    write_scene();
    std::string text[2];
    const char* const threads[] = {"1", "3"};
    for (int k = 0; k < 2; ++k) {
        const Outcome baked =
            run({"bake", "room.toml", "-o", "out", "--error", "3%", "--face-size", "32", "--threads",
                 threads[k], "--no-render", "--worst", "--report", "report.json"});
        ASSERT_EQ(baked.code, 0) << baked.err;
        EXPECT_NE(baked.out.find("error  "), std::string::npos) << baked.out;
        text[k] = text_of(folder_ / "out/room.ply");
    }
    EXPECT_TRUE(text[0] == text[1] && !text[0].empty());
    const nlohmann::json made = report("report.json"), &error = made["error"];
    EXPECT_EQ(error["target"], 0.03);
    EXPECT_EQ(error["is_met"], true);
    EXPECT_EQ(error["reason"], "");
    EXPECT_EQ(error["over"], "pixels");
    EXPECT_LE(error["reached"], 0.03);
    EXPECT_GT(error["reached"], 0.0075);
    EXPECT_LE(error["low"], error["reached"]);
    EXPECT_GE(error["high"], error["reached"]);
    for (const char* cause : {"between_vertices", "at_vertices", "indirect_light"})
        EXPECT_LE(error[cause], 0.03) << cause;
    EXPECT_GT(error["worst"]["error"], error["reached"]);
    EXPECT_EQ(error["worst"]["pixel"].size(), 2u);
    EXPECT_GT(text_of(folder_ / "out/worst.png").size(), 1000u);
    EXPECT_LT(made["vertices"], 4000);
    // No field is needed where all objects are rasterized at each point.
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out/fields"));

    const Outcome missed =
        run({"bake", "room.toml", "-o", "out", "--error", "0.001", "--vertex-budget", "100", "--everywhere",
             "--face-size", "16", "--no-render", "--report", "report.json"});
    ASSERT_EQ(missed.code, 0) << missed.err;
    EXPECT_NE(missed.err.find("expected at most 0.1 %: "), std::string::npos) << missed.err;
    const nlohmann::json report_of_missed = report("report.json")["error"];
    EXPECT_EQ(report_of_missed["is_met"], false);
    EXPECT_EQ(report_of_missed["over"], "surfaces");
    EXPECT_FALSE(report_of_missed["worst"].contains("pixel"));
    const Outcome both = run({"bake", "room.toml", "-o", "out", "--error", "1%", "--refine", "0.01"});
    EXPECT_EQ(both.code, 1);
    EXPECT_NE(both.err.find("expected neither refine"), std::string::npos) << both.err;
    EXPECT_EQ(run({"bake", "room.toml", "-o", "out", "--error", "off", "--everywhere"}).code, 1);
    EXPECT_EQ(run({"bake", "room.toml", "-o", "out", "--error", "200%"}).code, 2);
}

TEST_F(Commands, PassesArePicturesScenesAndColumns) {
    write_scene();
    const std::vector<std::string> names{"diffuse", "specular", "irradiance", "occlusion", "own-shadow"};
    const std::vector<std::string> bake{"bake",     "room.toml",   "--error",   "off",      "--face-size",
                                        "16",       "--fields",    "fields",    "--format", "csv,ply,glb",
                                        "--report", "report.json", "--bounces", "0"};
    const auto run_with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), bake.begin(), bake.end());
        return run(more);
    };
    const Outcome baked =
        run_with({"-o", "out", "--pass", "diffuse,specular,irradiance,occlusion,own-shadow"});
    ASSERT_EQ(baked.code, 0) << baked.err;
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string& name = names[i];
        EXPECT_GT(text_of(folder_ / "out" / (name + ".exr")).size(), 100u) << name;
        EXPECT_GT(text_of(folder_ / "out" / (name + ".png")).size(), 100u) << name;
        EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / name / ("room_" + name + "_Box.inc")));
        const nlohmann::json pass = report("report.json").at("passes").at(i);
        EXPECT_EQ(pass.value("pass", ""), name);
        EXPECT_EQ(pass.value("scene", ""), "out/" + name + "/room_" + name + ".pov");
        EXPECT_EQ(pass.value("image", ""), "out/" + name + ".exr");
    }
    // Diffuse clay.
    std::istringstream table(text_of(folder_ / "out/room.csv"));
    std::string line;
    std::getline(table, line);
    EXPECT_TRUE(
        line.ends_with("radiance_b,diffuse_r,diffuse_g,diffuse_b,specular_r,specular_g,specular_b,"
                       "irradiance_r,irradiance_g,irradiance_b,occlusion,own_shadow_r,own_shadow_g,"
                       "own_shadow_b"))
        << line;
    int vertices = 0, shadowed = 0;
    for (; std::getline(table, line); ++vertices) {
        std::vector<float> numbers;
        std::istringstream cells(line);
        std::string cell;
        std::getline(cells, cell, ',');
        while (std::getline(cells, cell, ',')) numbers.push_back(std::stof(cell));
        ASSERT_EQ(numbers.size(), 10u + 13u);
        const float red = numbers[7];
        EXPECT_EQ(numbers[10], red);
        EXPECT_EQ(numbers[13], 0.0f);
        EXPECT_NEAR(numbers[16] * 0.6f / 3.14159265f, red, 2e-3f * red + 1e-4f) << line;  // its albedo is 0.6
        EXPECT_TRUE(numbers[19] >= 0 && numbers[19] <= 1) << line;
        EXPECT_GE(numbers[20], red * 0.98f - 1e-3f) << line;
        shadowed += numbers[20] > 1.05f * red;
    }
    EXPECT_GT(vertices, 2300);
    EXPECT_GT(shadowed, 50);
    EXPECT_LT(shadowed, vertices - 50);

    const Outcome fitted = run_with({"-o", "fitted", "--no-render", "--refine", "0.02", "--vertex-budget",
                                     "900", "--colours", "fitted", "--pass", "specular,own-shadow"});
    EXPECT_EQ(fitted.code, 0) << fitted.err;
    EXPECT_TRUE(std::filesystem::exists(folder_ / "fitted/own-shadow/room_own-shadow.pov"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "fitted/own-shadow.exr"));
    const Outcome dense =
        run_with({"-o", "dense", "--no-render", "--evaluator", "dense", "--pass", "own-shadow"});
    EXPECT_EQ(dense.code, 0) << dense.err;
    const Outcome twice = run_with({"-o", "twice", "--pass", "diffuse,occlusion,diffuse"});
    EXPECT_EQ(twice.code, 1);
    EXPECT_NE(twice.err.find("pass diffuse: is listed twice"), std::string::npos) << twice.err;
    EXPECT_EQ(run_with({"-o", "none", "--pass", "beauty"}).code, 2);
}

/// The box has an additional vertex, which no face uses.
TEST_F(Commands, BakesTheVerticesOfTheFilesAndNoOthers) {
    write_scene();
    std::ofstream(folder_ / "box.obj", std::ios::app) << "v 7 7 7\n";
    const Outcome baked =
        run({"bake", "room.toml", "-o", "out", "--face-size", "16", "--no-render", "--format", "ply,csv,glb",
             "--original-vertices", "--pass", "occlusion", "--bounces", "0", "--report", "report.json"});
    ASSERT_EQ(baked.code, 0) << baked.err;
    EXPECT_NE(baked.err.find("fine_vertices of entity floor has no effect"), std::string::npos) << baked.err;
    EXPECT_NE(baked.err.find("1 of the files' 13 vertices belong to no triangle"), std::string::npos)
        << baked.err;
    EXPECT_EQ(report("report.json").at("original_vertices"),
              (nlohmann::json{{"vertices", 13}, {"unvalued", 1}}));
    const haarfield::Result<haarfield::PolygonFile> ply =
        haarfield::read_ply(text_of(folder_ / "out/room.ply"));
    ASSERT_TRUE(ply) << ply.error().message();
    ASSERT_EQ(ply->positions.size(), 13u);
    EXPECT_EQ(ply->face_corners, std::vector<std::uint32_t>(7, 4));
    EXPECT_EQ(ply->positions[0], haarfield::Vec3f(-3, 0, -3));
    EXPECT_EQ(ply->positions[4], haarfield::Vec3f(-0.5f, 0.001f, -0.5f));
    EXPECT_EQ(ply->positions[12], haarfield::Vec3f(7, 7.001f, 7));
    const std::vector<std::uint32_t> lid(ply->corners.begin() + 8, ply->corners.begin() + 12);
    EXPECT_EQ(lid, (std::vector<std::uint32_t>{11, 10, 9, 8}));

    // The values are means over the vertices that are baked for each corner.
    std::istringstream table(text_of(folder_ / "out/room.csv"));
    std::string line;
    std::getline(table, line);
    EXPECT_TRUE(line.ends_with(",occlusion")) << line;
    std::vector<std::string> lines;
    while (std::getline(table, line)) lines.push_back(line);
    ASSERT_EQ(lines.size(), 13u);
    EXPECT_TRUE(lines[3].starts_with("floor,3,-3,0,3,0,1,0,")) << lines[3];
    EXPECT_TRUE(lines[12].starts_with("box,8,7,7.001,7,0,1,0,0,0,0,0")) << lines[12];

    EXPECT_EQ(run({"bake", "room.toml", "-o", "out", "--original-vertices", "--refine", "0.01"}).code, 2);
    const Outcome plain =
        run({"bake", "room.toml", "-o", "plain", "--error", "off", "--face-size", "16", "--no-render"});
    ASSERT_EQ(plain.code, 0) << plain.err;
    const std::string text = text_of(folder_ / "plain/room.ply");
    const std::size_t data = text.find("end_header\n") + 11;
    std::map<std::int32_t, std::set<std::int32_t>> originals;  // by instance
    const std::size_t vertices = std::stoul(text.substr(text.find("element vertex ") + 15));
    for (std::size_t v = 0; v < vertices; ++v) {
        std::array<std::int32_t, 2> numbers;
        std::memcpy(numbers.data(), &text[data + 47 * v + 39], sizeof numbers);
        originals[numbers[0]].insert(numbers[1]);
    }
    EXPECT_EQ(originals[0], (std::set<std::int32_t>{-1, 0, 1, 2, 3}));
    EXPECT_EQ(originals[1], (std::set<std::int32_t>{-1, 0, 1, 2, 3, 4, 5, 6, 7}));

    // The fields are reused.
    const Outcome again =
        run({"precompute", "room.toml", "-o", "out", "--face-size", "16", "--original-vertices"});
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_EQ(again.out.find("made"), std::string::npos) << again.out;
}

TEST_F(Commands, ViewMovesTheCameraAndDenseAgreesWithTree) {
    write_scene();
    const std::vector<std::string> common{"bake",
                                          "room.toml",
                                          "--error",
                                          "off",
                                          "--face-size",
                                          "16",
                                          "--coefficients",
                                          "0",
                                          "--light-coefficients",
                                          "0",
                                          "--no-render",
                                          "--fields",
                                          "fields",
                                          "-o"};
    const auto bake = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments = common;
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
    };
    bake({"tree"});
    bake({"moved", "--view", "-1,2.5,-3"});
    bake({"dense", "--evaluator", "dense"});
    EXPECT_FALSE(text_of(folder_ / "tree/room_Box.inc").empty());
    EXPECT_NE(text_of(folder_ / "tree/room.pov"), text_of(folder_ / "moved/room.pov"));
    // Diffuse: the same from everywhere.
    EXPECT_EQ(text_of(folder_ / "tree/room_Box.inc"), text_of(folder_ / "moved/room_Box.inc"));
    EXPECT_NE(text_of(folder_ / "tree/room_Box.inc"), text_of(folder_ / "dense/room_Box.inc"));
}

TEST_F(Commands, RaysNeedNoFieldsAndHaveTheBouncesThatAreAskedFor) {
    write_scene();
    const auto mean = [&](std::vector<std::string> more) {
        std::vector<std::string> arguments{"bake", "room.toml",   "-o",       "out",         "--format",
                                           "csv",  "--no-render", "--report", "report.json", "--error",
                                           "off",  "--face-size", "16"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        std::istringstream table(text_of(folder_ / "out/room.csv"));
        std::string line;
        std::getline(table, line);
        double sum = 0;
        int vertices = 0;
        for (; std::getline(table, line); ++vertices) {
            std::istringstream cells(line);
            std::string cell;
            for (int c = 0; c <= 8; ++c) std::getline(cells, cell, ',');
            sum += std::stod(cell);
        }
        return sum / vertices;
    };
    const std::vector<std::string> rays{"--evaluator", "rays", "--samples", "1024"};
    const auto by_rays = [&](const std::string& bounces) {
        std::vector<std::string> arguments = rays;
        if (!bounces.empty()) arguments.insert(arguments.end(), {"--bounces", bounces});
        return mean(arguments);
    };
    const double none = by_rays("0"), one = by_rays("1"), all = by_rays("");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out/fields"));
    EXPECT_TRUE(report("report.json").at("fields").empty());
    EXPECT_LT(none, 0.99 * one);
    EXPECT_LT(one, all);
    EXPECT_NEAR(none / mean({"--bounces", "0"}), 1, 0.03);
    EXPECT_NEAR(all / mean({}), 1, 0.03);
}

TEST_F(Commands, TheCameraIsPlacedIfTheSceneHasNoneOrOnRequest) {
    write_scene();
    const auto camera_of = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), {"-o", "out", "--report", "report.json"});
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return report("report.json")["camera"];
    };
    const auto bake = [&](const std::string& option) {
        return camera_of({"bake", "room.toml", "--error", "off", "--face-size", "16", "--no-render", option});
    };
    const nlohmann::json given = bake("--quiet"), framed = bake("--frame");
    EXPECT_EQ(given["found"], false);
    EXPECT_EQ(given["position"], (std::vector<double>{2.5, 2, 3}));
    EXPECT_EQ(framed["found"], true);
    EXPECT_NE(framed["position"], given["position"]);

    const std::string scene = text_of(folder_ / "room.toml");
    std::ofstream(folder_ / "room.toml")
        << std::regex_replace(scene, std::regex("(position|target) = .*\n"), "");
    EXPECT_EQ(bake("--quiet"), framed);
    EXPECT_EQ(camera_of({"reference", "room.toml", "--lights", "16"}), framed);
    const nlohmann::json moved = bake("--view=1,5,2");
    EXPECT_EQ(moved["position"], (std::vector<double>{1, 5, 2}));
    EXPECT_EQ(moved["target"], framed["target"]);
    const std::string outside = report("report.json")["warnings"].dump();
    EXPECT_EQ(outside.find("camera"), std::string::npos) << outside;
    bake("--view=0.2,0.5,0.1");
    const nlohmann::json inside = report("report.json");
    EXPECT_EQ(inside["warnings"].back(),
              "the camera is inside box; if that is a room, add faces = \"inwards\" to [entities.box]");
}

TEST_F(Commands, QuietPrintsOnlyJson) {
    write_scene();
    ASSERT_EQ(run({"precompute", "room.toml", "-o", "out", "--face-size", "16", "--quiet"}).code, 0);
    const std::string box = haarfield::field_of(folder_ / "out/fields", "box");
    using Arguments = std::vector<std::string>;
    for (Arguments arguments :
         {Arguments{"bake", "room.toml", "-o", "out", "--error", "off", "--face-size", "16", "--antialiasing",
                    "0", "--frame", "--exposure", "auto"},
          {"reference", "room.toml", "-o", "out", "--lights", "16", "--antialiasing", "0"},
          {"compare", "out/baked.exr", "out/reference.exr", "-o", "out"},
          {"relight", "room.toml", "-o", "out", "--face-size", "16", "--spin-light", "--frames", "1"},
          {"info", box},
          {"verify", box}}) {
        arguments.emplace_back("--quiet");
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << arguments[0] << outcome.err;
        EXPECT_EQ(outcome.out + outcome.err, "") << arguments[0];
    }
    const Outcome asked = run({"info", box, "--quiet", "--json"});
    EXPECT_EQ(nlohmann::json::parse(asked.out, nullptr, false).value("entity", ""), "box") << asked.out;
    EXPECT_NE(run({"info", "missing.vdb", "--quiet"}).err, "");
}

TEST_F(Commands, BakeAndReferenceFindTheSameExposureAndReportClipping) {
    write_scene();
    const auto made = [&](std::vector<std::string> arguments, const std::string& exposure) {
        arguments.insert(arguments.end(), {"room.toml", "-o", "out", "--report", "report.json"});
        if (!exposure.empty()) arguments.push_back("--exposure=" + exposure);
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return std::pair(report("report.json"), outcome.err);
    };
    const std::vector<std::string> bake{"bake", "--error", "off", "--face-size", "16", "--antialiasing", "0"},
        trace{"reference", "--lights", "16", "--antialiasing", "0"};
    const auto [baked, words] = made(bake, "auto");
    EXPECT_EQ(baked["environments"][0]["found"], true);
    EXPECT_EQ(baked["environments"][0]["from"], "sky");
    EXPECT_LT(baked["clipped_share"], 0.02);
    EXPECT_EQ(words.find("brighter than 1"), std::string::npos) << words;
    const nlohmann::json traced = made(trace, "auto").first;
    EXPECT_EQ(traced["environments"], baked["environments"]);
    EXPECT_TRUE(traced.contains("clipped_share"));

    const auto [bright, complaint] = made(bake, "6");
    EXPECT_EQ(bright["environments"][0]["found"], false);
    EXPECT_EQ(bright["environments"][0]["exposure"], 6);
    EXPECT_GT(bright["clipped_share"], 0.9);
    EXPECT_NE(complaint.find("brighter than 1"), std::string::npos) << complaint;
    EXPECT_EQ(made(bake, "").first["environments"][0]["exposure"], 0);
}

TEST_F(Commands, CtrlCEndsABakeWithoutPartialFiles) {
    write_scene(/*fine_vertices=*/1'000'000);
    for (const int signal : {SIGINT, SIGTERM}) {
        const pid_t child = start({"bake", "room.toml", "-o", "out", "--error", "off"});
        // Until the long stage says how far it is; or until the program ends, which is a failure.
        const auto running = [child] {
            siginfo_t state{};
            return waitid(P_PID, static_cast<id_t>(child), &state, WEXITED | WNOHANG | WNOWAIT) == 0 &&
                   state.si_pid == 0;
        };
        while (running() && text_of(folder_ / "stderr.txt").find("left") == std::string::npos)
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        kill(child, signal);
        const Outcome outcome = finish(child);
        EXPECT_EQ(outcome.code, 130) << outcome.err;
        EXPECT_NE(outcome.err.find("left"), std::string::npos) << outcome.err;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "out"))
            EXPECT_TRUE(entry.is_directory() || entry.path().filename().string().starts_with("floor-"))
                << entry.path();
    }
}

/// HAARFIELD_KILLS in the environment sets the number of kills; the default is six.
TEST_F(Commands, AKilledPrecomputeLeavesCompleteFieldsAndCanBeContinued) {
    write_scene();
    const std::vector<std::string> precompute{"precompute", "room.toml", "--face-size", "32", "-o"};
    const auto into = [&](const char* output) {
        std::vector<std::string> arguments = precompute;
        arguments.emplace_back(output);
        return arguments;
    };
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(run(into("whole")).code, 0);
    const std::chrono::duration<double> undisturbed = std::chrono::steady_clock::now() - begin;
    std::map<std::string, std::string> wanted;  // two fields and a prepared mesh by their files' names
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "whole/fields"))
        wanted[entry.path().filename()] = text_of(entry.path());
    ASSERT_EQ(wanted.size(), 3u);

    const std::filesystem::path fields = folder_ / "out/fields";
    const auto finished = [&] {
        std::set<std::string> names;
        for (const auto& [name, bytes] : wanted)
            if (std::filesystem::exists(fields / name)) names.insert(name);
        return names;
    };
    const char* const asked = std::getenv("HAARFIELD_KILLS");
    const int kills = asked ? std::atoi(asked) : 6;
    std::mt19937 random(9);
    int between = 0, leftovers = 0;
    for (int k = 0; k < kills; ++k) {
        if (k % 3 == 0) std::filesystem::remove_all(folder_ / "out");  // otherwise continues the killed run
        const std::set<std::string> before = finished();
        const pid_t child = start(into("out"));
        std::this_thread::sleep_for(undisturbed * (static_cast<double>(random() % 1000) / 1000));
        kill(child, SIGKILL);
        finish(child);
        const std::set<std::string> after = finished();
        EXPECT_TRUE(std::ranges::includes(after, before)) << "kill " << k << ": a field was lost";
        for (const std::string& name : after)
            EXPECT_TRUE(text_of(fields / name) == wanted[name]) << "kill " << k << ": " << name;
        between += !after.empty() && after.size() < wanted.size();
        std::error_code none;
        for (std::filesystem::directory_iterator entry(fields, none), end; entry != end; ++entry)
            leftovers += !wanted.contains(entry->path().filename());
    }
    RecordProperty("killed_between_fields", between);
    RecordProperty("killed_while_one_was_made", leftovers);
    EXPECT_EQ(run(into("out")).code, 0);
    for (const auto& entry : std::filesystem::directory_iterator(fields))
        EXPECT_TRUE(text_of(entry.path()) == wanted[entry.path().filename().string()]) << entry.path();
    EXPECT_EQ(finished().size(), wanted.size());
}

TEST_F(Commands, TwoProcessesInOneFolderMakeEachFieldOnce) {
    write_scene();
    const auto arguments = [](const char* report) {
        return std::vector<std::string>{"precompute",  "room.toml", "-o",       "out",
                                        "--face-size", "32",        "--report", report};
    };
    const pid_t first = start(arguments("first.json")), second = start(arguments("second.json"));
    EXPECT_EQ(finish(first).code, 0);
    EXPECT_EQ(finish(second).code, 0);
    std::map<std::string, int> made;
    for (const char* name : {"first.json", "second.json"}) {
        const nlohmann::json done = report(name);
        for (const nlohmann::json& field : done.at("fields"))
            made[field.at("entity")] += field.at("reused") == false;
    }
    EXPECT_EQ(made, (std::map<std::string, int>{{"box", 1}, {"floor", 1}}));
    for (const char* name : {"box", "floor"})
        EXPECT_EQ(run({"verify", haarfield::field_of(folder_ / "out/fields", name)}).code, 0) << name;
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / "out/fields"), {}), 3)
        << "with a mesh";
}

}  // namespace
