#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iterator>
#include <random>
#include <sstream>
#include <thread>

#include "tests/farm/farm_test.h"

namespace haarfield {
namespace {

using Words = std::vector<std::string>;

/// Returns the number of kills: HAARFIELD_KILLS in the environment, or a default.
int asked_kills(int otherwise) {
    const char* const asked = std::getenv("HAARFIELD_KILLS");
    return asked ? std::atoi(asked) : otherwise;
}

/// Splits the options of a command into words.
Words words_in(const std::string& text) {
    std::istringstream stream(text);
    return {std::istream_iterator<std::string>(stream), {}};
}

TEST_F(FarmTest, JoinedResultsEqualUndividedOnes) {
    write_scene();
    const std::string bake =
                          "--error off --face-size 16 --bounces 0 --antialiasing 2 --pass "
                          "own-shadow,occlusion --format ply,glb",
                      reference = "--lights 16 --antialiasing 2",
                      relight = "--face-size 16 --move box_2 2,0.001,0:1,0.001,1 --frames 5";
    const auto undivided = [&](const std::string& command, const std::string& options) {
        Words words{command, "room.toml", "-o", "whole"};
        if (command != "reference") words.insert(words.end(), {"--fields", "whole_fields"});
        std::ranges::copy(words_in(options), std::back_inserter(words));
        expect_done(words);
    };
    undivided("bake", bake);
    undivided("reference", reference);
    undivided("relight", relight);
    // One process per task, and several tasks per process, in another order than that of the plan.
    for (const int tasks : {1, 7}) {
        const std::string plan = fmt::format("plan_{}", tasks);
        expect_done({"plan", "room.toml", "-o", plan, "--want", "bake,reference,relight", "--bake-options",
                     bake, "--reference-options", reference, "--relight-options", relight, "--tasks",
                     std::to_string(tasks)});
        const std::size_t count = task_count(plan);
        EXPECT_EQ(count, tasks == 7 ? 2u * 7 + 7 + 4 + 5 : 2u + 1 + 2 + 1);
        const Words lists =
            tasks == 7 ? Words{"15,20-28", "0-3,9", "2-19,29"} : Words{"3", "1", "5", "4", "0", "2"};
        for (const std::string& list : lists) expect_worked(plan, list);
        EXPECT_EQ(status(plan).value("done", std::size_t(0)), count);
        expect_done({"join", plan});
        expect_same_files(plan + "/results/room", "whole");
        expect_same_files(plan + "/fields", "whole_fields");
    }
}

TEST_F(FarmTest, SixtyFourTasksEqualOne) {
    write_scene();
    const std::string bake = "--face-size 16 --bounces 0 --no-render --colours fitted";
    expect_done({"bake", "room.toml", "-o", "whole", "--fields", "whole_fields", "--face-size", "16",
                 "--bounces", "0", "--no-render", "--colours", "fitted"});
    expect_done({"plan", "room.toml", "-o", "plan", "--bake-options", bake, "--tasks", "64"});
    const std::size_t count = task_count("plan");
    ASSERT_EQ(count, 3u * 64);
    for (const char* list : {"101-191", "1-63,65-99", "0,64,100"}) expect_worked("plan", list);
    expect_done({"join", "plan"});
    expect_same_files("plan/results/room", "whole");
    expect_same_files("plan/fields", "whole_fields");
}

TEST_F(FarmTest, BouncesAreOneTaskAfterDirectLight) {
    write_scene();
    const std::string options =
        "--error off --face-size 16 --antialiasing 0 --pass own-shadow,indirect,diffuse --format ply,glb";
    Words bake{"bake", "room.toml", "-o", "whole", "--fields", "whole_fields"};
    std::ranges::copy(words_in(options), std::back_inserter(bake));
    expect_done(bake);
    for (const std::size_t tasks : {1, 7}) {
        const std::string plan = fmt::format("plan_{}", tasks);
        expect_done({"plan", "room.toml", "-o", plan, "--fields", "whole_fields", "--bake-options", options,
                     "--tasks", std::to_string(tasks)});
        const std::size_t count = task_count(plan), first = 2 * tasks;
        ASSERT_EQ(count, first + (tasks == 1 ? 1 : tasks + 1));
        // With seven tasks, indirect light comes first and finds one part of the direct light.
        if (tasks == 7) {
            expect_worked(plan, fmt::format("{}", first + 3));
            expect_worked(plan, fmt::format("{}", count - 1));
        }
        expect_all_worked(plan);
        expect_done({"join", plan});
        expect_same_files(plan + "/results/room", "whole");
    }
}

TEST_F(FarmTest, TasksThatRunTogetherAreEachSkippedOnceTheyAreDone) {
    write_scene();
    expect_done({"plan", "room.toml", "-o", "plan", "--tasks", "4", "--bake-options",
                 "--error off --face-size 16 --bounces 0 --no-render"});
    const Outcome some = run({"work", "plan", "--tasks", "1-2,5"});
    EXPECT_EQ(some.code, 0) << some.err;
    EXPECT_NE(some.out.find("tasks  1-2 done in"), std::string::npos) << some.out;
    EXPECT_NE(some.out.find("task   5 done in"), std::string::npos) << some.out;
    const Outcome more = run({"work", "plan", "--tasks", "0-3"});
    EXPECT_EQ(more.code, 0) << more.err;
    for (const char* line :
         {"task   1 was already done", "task   2 was already done", "task   0 done in", "task   3 done in"})
        EXPECT_NE(more.out.find(line), std::string::npos) << line << ": " << more.out;
    EXPECT_EQ(status("plan").value("done", 0), 5);
    const Outcome beyond = run({"work", "plan", "--tasks", "3-12"});
    EXPECT_EQ(beyond.code, 1);
    EXPECT_NE(beyond.err.find("at most 11, the plan's last task"), std::string::npos) << beyond.err;

    // A failure leaves the tasks of other jobs.
    write_text(folder / "floor.obj", text_of(folder / "floor.obj") + "# changed\n");
    const Outcome failed = run({"work", "plan", "--tasks", "0-11"});
    EXPECT_EQ(failed.code, 1);
    EXPECT_NE(failed.err.find("floor.obj"), std::string::npos) << failed.err;
    const nlohmann::json state = status("plan");
    EXPECT_EQ(state.value("done", 0), 8) << "the field of the box, and task 5";
    EXPECT_EQ(state.value("failed", 0), 4) << state;
}

TEST_F(FarmTest, IndivisibleWorkIsOneTask) {
    write_scene();
    expect_done({"bake", "room.toml", "-o", "whole", "--fields", "whole_fields", "--face-size", "16",
                 "--refine", "0.1", "--vertex-budget", "500", "--no-render"});
    expect_done({"plan", "room.toml", "-o", "plan", "--tasks", "3", "--bake-options",
                 "--face-size 16 --refine 0.1 --vertex-budget 500 --no-render"});
    const std::size_t count = task_count("plan");
    EXPECT_EQ(count, 2u * 3 + 1);
    expect_all_worked("plan");
    expect_done({"join", "plan"});
    expect_same_files("plan/results/room", "whole");
}

TEST_F(FarmTest, TasksShareTheFirstDirectLightOfASearch) {
    write_scene();
    expect_done(
        {"bake", "room.toml", "-o", "whole", "--error", "20%", "--pass", "irradiance", "--no-render"});
    expect_done({"plan", "room.toml", "-o", "plan", "--tasks", "3", "--bake-options",
                 "--error 20% --pass irradiance --no-render"});
    // A search computes the samples that it uses, here none.
    const std::size_t count = task_count("plan");
    ASSERT_EQ(count, 3u + 1);
    for (std::size_t task = 0; task + 1 < count; ++task) EXPECT_EQ(work("plan", task).code, 0) << task;
    // The last task computes missing parts itself.
    std::filesystem::remove(folder / "plan/parts/1.part");
    EXPECT_EQ(work("plan", count - 1).code, 0);
    EXPECT_EQ(work("plan", 1).code, 0);
    expect_done({"join", "plan"});
    expect_same_files("plan/results/room", "whole");
}

TEST_F(FarmTest, KilledTasksAreRepeatedAndLeaveNoPartialFiles) {
    write_scene();
    expect_done({"bake", "room.toml", "-o", "whole", "--fields", "whole_fields", "--error", "off",
                 "--face-size", "32", "--no-render"});
    expect_done({"plan", "room.toml", "-o", "plan", "--tasks", "2", "--bake-options",
                 "--error off --face-size 32 --no-render"});
    const std::size_t count = task_count("plan");
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(work("plan", 0).code, 0);
    const std::chrono::duration<double> undisturbed = std::chrono::steady_clock::now() - begin;
    std::mt19937 random(5);
    int killed = 0;  // others end before
    for (int attempt = 0; killed < asked_kills(8); ++attempt) {
        if (attempt % int(count) == 0) {  // starts again from nothing
            std::filesystem::remove_all(folder / "plan/parts");
            std::filesystem::create_directories(folder / "plan/parts");
            std::filesystem::remove_all(folder / "plan/fields");
        }
        // One task, or several in one process.
        const std::size_t first = random() % count, last = std::min(count - 1, first + random() % 3);
        const pid_t child = start({"work", "plan", "--tasks", fmt::format("{}-{}", first, last)});
        std::this_thread::sleep_for(undisturbed * (static_cast<double>(random() % 1000) / 1000));
        kill(child, SIGKILL);
        killed += finish(child).code == -SIGKILL;
    }
    // Runs each task twice at the same time.
    for (std::size_t task = 0; task < count; ++task) {
        const pid_t first = start({"work", "plan", "--task", std::to_string(task)}),
                    second = start({"work", "plan", "--task", std::to_string(task)});
        EXPECT_EQ(finish(first).code, 0) << task;
        EXPECT_EQ(finish(second).code, 0) << task;
    }
    expect_done({"join", "plan"});
    expect_same_files("plan/results/room", "whole");
    expect_same_files("plan/fields", "whole_fields");
}

TEST_F(FarmTest, JoinNamesMissingAndDamagedResultsAndWorkRepairsThem) {
    write_scene();
    expect_done({"plan", "room.toml", "-o", "plan", "--tasks", "2", "--bake-options",
                 "--error off --face-size 16 --bounces 0 --no-render"});
    const std::size_t count = task_count("plan");
    ASSERT_EQ(count, 6u);
    EXPECT_EQ(run({"plan", "room.toml", "-o", "plan"}).code, 1) << "there is one already";
    expect_worked("plan", "0-4");
    const Outcome missing = run({"join", "plan"});
    EXPECT_EQ(missing.code, 1);
    EXPECT_NE(missing.err.find("task 5"), std::string::npos) << missing.err;
    ASSERT_EQ(work("plan", 5).code, 0);
    expect_done({"join", "plan"});
    const auto joined = files_below("plan/results");

    std::string bytes = text_of(folder / "plan/parts/4.part");
    bytes[bytes.size() / 2] ^= 1;
    write_text(folder / "plan/parts/4.part", bytes);
    write_text(folder / "plan/parts/1.part", text_of(folder / "plan/parts/0.part"));
    const Outcome damaged = run({"join", "plan", "--report", "report.json"});
    EXPECT_EQ(damaged.code, 1);
    EXPECT_NE(damaged.err.find("task 4"), std::string::npos) << damaged.err;
    const auto report = nlohmann::json::parse(text_of(folder / "report.json"), nullptr, false);
    EXPECT_EQ(report.value("bad_tasks", std::vector<int>()), (std::vector<int>{1, 4}));
    const Outcome verified = run({"status", "plan", "--verify"});
    EXPECT_EQ(verified.code, 1);
    EXPECT_NE(verified.out.find("--tasks 1,4"), std::string::npos) << verified.out;
    expect_worked("plan", "1,4");
    expect_done({"status", "plan", "--verify"});
    expect_done({"join", "plan"});
    EXPECT_TRUE(files_below("plan/results") == joined);
    EXPECT_NE(work("plan", 4).out.find("already done"), std::string::npos);

    write_scene("room", 250);
    std::filesystem::remove(folder / "plan/parts/4.part");
    const Outcome changed = work("plan", 4);
    EXPECT_EQ(changed.code, 1);
    EXPECT_NE(changed.err.find("changed since the plan was made"), std::string::npos) << changed.err;
    const nlohmann::json state = status("plan");
    EXPECT_EQ(state.value("done", 0), 5);
    EXPECT_EQ(state.value("failed", 0), 1);
    EXPECT_EQ(run({"join", "plan"}).code, 1);
}

TEST_F(FarmTest, TheInstructionSetIsStoredAndAMissingOneIsRefused) {
    write_scene();
    const Outcome unknown = run({"plan", "room.toml", "-o", "none", "--instructions", "SVE9"});
    EXPECT_EQ(unknown.code, 1);
    EXPECT_NE(unknown.err.find("SVE9"), std::string::npos) << unknown.err;
    const Words bake{"--bake-options", "--error off --face-size 16 --no-render", "--instructions", "AVX2"};
    for (const char* tasks : {"1", "3"}) {
        const std::string plan = std::string("plan_") + tasks;
        Words words{"plan", "room.toml", "-o", plan, "--tasks", tasks};
        words.insert(words.end(), bake.begin(), bake.end());
        const Outcome planned = run(words);
        if (planned.code != 0) GTEST_SKIP() << planned.err;
        expect_all_worked(plan);
        expect_done({"join", plan});
    }
    expect_same_files("plan_3/results", "plan_1/results");
    expect_same_files("plan_3/fields", "plan_1/fields");
}

TEST_F(FarmTest, ManyProcessesFillOneLibraryWithCompleteFieldsOnly) {
    for (const int scene : {0, 1, 2, 3})
        write_scene(fmt::format("room_{}", scene), 200, scene < 3 ? 1.0f : 0.5f);  // two boxes, one floor
    const auto precompute = [](int scene) {
        return Words{"precompute", fmt::format("room_{}.toml", scene), "--fields", "library", "--face-size",
                     "32"};
    };
    // First, processes are killed at random moments.
    std::mt19937 random(8);
    int killed = 0;  // others end before
    for (int i = 0; killed < asked_kills(6); ++i) {
        // Complete fields are reused, so the library is emptied at intervals.
        if (i % 8 == 0) std::filesystem::remove_all(folder / "library");
        const pid_t child = start(precompute(i % 4));
        std::this_thread::sleep_for(std::chrono::milliseconds(random() % 300));
        kill(child, SIGKILL);
        killed += finish(child).code == -SIGKILL;
        for (const auto& [name, bytes] : files_below("library"))
            if (name.ends_with(".vdb")) {
                EXPECT_EQ(run({"verify", "library/" + name}).code, 0) << name;
            }
    }
    std::filesystem::remove_all(folder / "library");
    std::vector<pid_t> children;
    for (int i = 0; i < 8; ++i) {
        Words words = precompute(i % 4);
        words.insert(words.end(), {"--report", fmt::format("report_{}.json", i)});
        children.push_back(start(words));
    }
    for (const pid_t child : children) EXPECT_EQ(finish(child).code, 0);
    int made = 0;
    for (int i = 0; i < 8; ++i) {
        const auto report =
            nlohmann::json::parse(text_of(folder / fmt::format("report_{}.json", i)), nullptr, false);
        for (const auto& field : report.at("fields")) made += field.at("reused") == false;
    }
    EXPECT_EQ(made, 3) << "two kinds of box, and the floor";
    EXPECT_EQ(files_below("library").size(), 3u);
    const auto library =
        nlohmann::json::parse(run({"library", "library", "--verify", "--json"}).out, nullptr, false);
    ASSERT_EQ(library.at("fields").size(), 3u);
    for (const auto& field : library.at("fields")) EXPECT_EQ(field.at("good"), true);
}

TEST_F(FarmTest, ALibraryIsListedVerifiedAndPruned) {
    write_scene();
    expect_done({"precompute", "room.toml", "--fields", "library", "--face-size", "16"});
    const Outcome listed = run({"library", "library"});
    EXPECT_EQ(listed.code, 0);
    EXPECT_NE(listed.out.find("2 fields"), std::string::npos) << listed.out;
    EXPECT_NE(listed.out.find("box"), std::string::npos) << listed.out;
    EXPECT_EQ(run({"library", "missing"}).code, 1);
    EXPECT_EQ(run({"library", "library", "--unused-for", "soon"}).code, 2);
    EXPECT_EQ(run({"library", "library", "--shrink-to", "-1MB"}).code, 2);
    for (const auto& [name, bytes] : files_below("library"))
        if (name.starts_with("box")) {
            std::filesystem::resize_file(folder / ("library/" + name), bytes.size() / 2);
            std::filesystem::last_write_time(
                folder / ("library/" + name),
                std::filesystem::file_time_type::clock::now() - std::chrono::hours(24 * 40));
        }
    const Outcome bad = run({"library", "library", "--verify"});
    EXPECT_EQ(bad.code, 1);
    EXPECT_NE(bad.out.find("1 damaged"), std::string::npos) << bad.out << bad.err;
    expect_done({"library", "library", "--unused-for", "30d", "--dry-run"});
    EXPECT_EQ(files_below("library").size(), 2u);
    expect_done({"library", "library", "--unused-for", "30d"});
    EXPECT_EQ(files_below("library").size(), 1u);
    expect_done({"library", "library", "--verify"});
    expect_done({"library", "library", "--shrink-to", "1kB"});
    EXPECT_EQ(files_below("library").size(), 0u);
}

TEST_F(FarmTest, GnuParallelRunsAPlanAndDoesLostAndDamagedTasksAgain) {
    if (std::system("command -v parallel > /dev/null") != 0) GTEST_SKIP() << "GNU parallel is not installed";
    write_scene();
    expect_done({"bake", "room.toml", "-o", "whole", "--fields", "whole_fields", "--error", "off",
                 "--face-size", "16", "--no-render"});
    expect_done({"plan", "room.toml", "-o", "a plan's", "--tasks", "3", "--threads", "1", "--bake-options",
                 "--error off --face-size 16 --no-render"});
    const char* const script = "sh \"a plan's/parallel.sh\" --tasks-per-job=2 --jobs 2";
    const Outcome first = shell(script);
    EXPECT_EQ(first.code, 0) << first.err;
    expect_same_files("a plan's/results/room", "whole");
    expect_same_files("a plan's/fields", "whole_fields");
    std::filesystem::remove(folder / "a plan's/parts/7.part");
    std::string bytes = text_of(folder / "a plan's/parts/8.part");
    bytes[bytes.size() / 2] ^= 1;
    write_text(folder / "a plan's/parts/8.part", bytes);
    const Outcome again = shell(script);
    EXPECT_EQ(again.code, 0) << again.err;
    expect_done({"status", "a plan's", "--verify"});
    EXPECT_EQ(status("a plan's").value("done", 0), 10);
    expect_same_files("a plan's/results/room", "whole");
}

TEST_F(FarmTest, TheSetupIsAtMostATenthOfTheEstimatedTaskTime) {
    write_scene("large", 3000000);
    // Returns the parts of the bake, and their total estimated time. [s]
    const auto bake = [&](const std::string& plan, const Words& division) {
        Words words{"plan", "large.toml", "-o", plan, "--bake-options", "--error off --bounces 0"};
        words.insert(words.end(), division.begin(), division.end());
        expect_done(words);
        const auto json = nlohmann::json::parse(text_of(folder / (plan + "/plan.json")), nullptr, false);
        const auto& job = json.at("jobs").back();
        const double parts = job.at("parts");
        return std::pair(parts, parts * job.at("part_seconds").get<double>());
    };
    const auto [one, whole] = bake("whole", {"--tasks", "1"});
    const auto [many, sum] = bake("short", {"--task-seconds", "1"});
    EXPECT_EQ(one, 1);
    EXPECT_GT(many, 1);
    EXPECT_LE(sum, 1.1 * whole);
    EXPECT_GT(bake("asked", {"--tasks", "100"}).second, 2 * whole);
}

TEST_F(FarmTest, TenThousandInstancesArePlannedAndSimulated) {
    write_scene();
    std::string scene = text_of(folder / "room.toml");
    for (int i = 0; i < 10000; ++i)
        scene += fmt::format("[[instances]]\nentity = \"box\"\ntranslate = [{}, 0.001, {}]\n",
                             2 + 1.5 * (i % 100), 1.5 * (i / 100));
    write_text(folder / "room.toml", scene);
    expect_done(
        {"plan", "room.toml", "-o", "plan", "--tasks", "10000", "--bake-options", "--error off --bounces 0"});
    const Outcome simulated = run({"status", "plan", "--nodes", "10,100,1000", "--json"});
    const auto state = nlohmann::json::parse(simulated.out, nullptr, false);
    EXPECT_EQ(state.value("tasks", 0), 30000);
    EXPECT_EQ(state.value("waiting", 0), 30000);
    const double one = state.value("seconds_left", 0.0) + 30000;  // a second each for the scheduler
    double before = one;
    for (const auto& time : state.at("simulated")) {
        const double seconds = time.at("seconds"), nodes = time.at("nodes");
        EXPECT_GE(seconds, one / nodes * 0.999);
        EXPECT_LE(seconds, one / nodes * 1.1 + 10);
        EXPECT_LT(seconds, before);
        before = seconds;
    }
}

}  // namespace
}  // namespace haarfield
