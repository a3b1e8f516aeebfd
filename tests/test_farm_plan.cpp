#include "tools/farm/farm_plan.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fixtures/test_folder.h"
#include "tools/farm/farm_status.h"
#include "tools/farm/task_batches.h"
#include "tools/farm/task_list.h"

#include <fmt/format.h>

namespace haarfield {
namespace {

FarmPlan example_plan() {
    FarmPlan plan;
    plan.version = HAARFIELD_VERSION;
    plan.id = "0123";
    plan.folder = "/rooms";
    plan.task_seconds = 300;
    const auto add = [&](std::vector<std::string> arguments, Division division, std::size_t parts) {
        plan.jobs.push_back({std::move(arguments), division, {{"room.toml", "00ff"}}, 0, 0, parts, 2.5});
    };
    add({"precompute", "room.toml", "-o", "out"}, Division::samples, 3);
    add({"reference", "room.toml", "-o", "out"}, Division::strips, 4);
    add({"bake", "room.toml", "-o", "out", "--error", "off", "--bounces", "0"}, Division::shading, 2);
    add({"bake", "room.toml", "-o", "out", "--error", "off"}, Division::undivided, 1);
    add({"relight", "room.toml", "-o", "out"}, Division::frames, 5);
    add({"bake", "room.toml", "-o", "other", "--error", "off"}, Division::direct, 2);
    add({"bake", "room.toml", "-o", "other", "--error", "off"}, Division::bounces, 1);
    plan.jobs.back().direct = 5;
    plan.stages = {0, 7, 17, 18};
    return plan;
}

/// Returns the plan that is read after a change of its JSON.
template <class Change>
Result<FarmPlan> changed_plan(const Change& change) {
    const TestFolder folder;
    auto json = nlohmann::ordered_json::parse(plan_text(example_plan()));
    change(json);
    write_text(folder / "plan.json", json.dump());
    return read_plan(folder.path());
}

TEST(FarmPlan, IsReadAsItWasWritten) {
    const Result<FarmPlan> plan = changed_plan([](auto&) {});
    ASSERT_TRUE(bool(plan)) << plan.error().message();
    EXPECT_EQ(plan_text(*plan), plan_text(example_plan()));
    const PlanTask task = plan->task(7);
    EXPECT_EQ(task.job, 2u);
    EXPECT_EQ(task.part, 0u);
}

TEST(FarmPlan, ValuesOfAWrongTypeOrOutOfRangeAreRefused) {
    using Json = nlohmann::ordered_json;
    const Json wrong = Json::parse(R"([
        ["/format", 1, "has format 1"], ["/format", "2", "has format string"], ["/format", 1e300, "has format"],
        ["/version", "0.0.0", "is a plan of haarfield 0.0.0"], ["/version", null, "version is null"],
        ["/id", 5, "id is 5"], ["/folder", "/a\u0000b", "a text without zeros"], ["/threads", 0, "threads is 0"],
        ["/threads", 1e300, "threads is 1e+300"], ["/threads", -1, "threads is -1"],
        ["/task_seconds", -1, "task_seconds is -1"], ["/task_seconds", null, "task_seconds is null"],
        ["/stages", [0, 7, 17], "3 stages"], ["/stages", [0, 19, 19, 18], "stages is 19"],
        ["/stages", [1, 7, 17, 18], "stages is 1"], ["/stages", [0, 7, 17, 17], "stages is 17"],
        ["/stages", [0, 7, 6, 18], "stages is 6"],
        ["/stages", [0, 7, 17, 1e300], "stages is 1e+300"], ["/stages", 15, "stages is 15"],
        ["/jobs", {"a": 1}, "jobs is object"], ["/jobs", [], "stages is 7"],
        ["/jobs/0/parts", 0, "parts is 0"], ["/jobs/0/parts", 3.5, "parts is 3.5"],
        ["/jobs/0/parts", 18446744073709551615, "parts is 18446744073709551615"],
        ["/jobs/0/parts", 1000000, "more than 1000000 tasks"],
        ["/jobs/1/parts", 1, "expected an even number"], ["/jobs/3/parts", 2, "parts is 2"],
        ["/jobs/0/part_seconds", 1e300, "part_seconds is 1e+300"], ["/jobs/0/part_bytes", -1, "part_bytes is -1"],
        ["/join_seconds", "1", "join_seconds is string"], ["/jobs/0/instance", -1, "instance is -1"],
        ["/jobs/0/division", "strips", "a precompute has an unknown or unsupported division"],
        ["/jobs/3/division", "shading", "a bake has an unknown or unsupported division"],
        ["/jobs/2/division", "bounces", "a bake has an unknown or unsupported division"],
        ["/jobs/3/division", "halves", "a bake has an unknown or unsupported division"],
        ["/jobs/6/direct", 6, "direct is 6"], ["/jobs/6/direct", 3, "direct is 3"],
        ["/jobs/6/arguments/3", "elsewhere", "direct is 5"], ["/jobs/6/direct", 1e300, "direct is 1e+300"],
        ["/jobs/3/division", "bounces", "direct is 0"], ["/jobs/6/parts", 2, "parts is 2"],
        ["/jobs/0/arguments", [], "a command that plans do not support"],
        ["/jobs/0/arguments/0", "library", "a command that plans do not support"],
        ["/jobs/0/arguments/1", ["a"], "arguments is array"], ["/jobs/0/inputs", "room.toml", "inputs is string"],
        ["/jobs/0/inputs/0/hash", 7, "hash is 7"]])");
    for (const Json& each : wrong) {
        const Result<FarmPlan> plan =
            changed_plan([&](Json& json) { json[Json::json_pointer(each[0].get<std::string>())] = each[1]; });
        ASSERT_FALSE(bool(plan)) << each;
        EXPECT_NE(plan.error().message().find(each[2].get<std::string>()), std::string::npos)
            << each << ": " << plan.error().message();
        EXPECT_NE(plan.error().where.find("plan.json"), std::string::npos) << each;
    }
}

TEST(FarmPlan, MissingKeysAndTruncatedPlansAreRefused) {
    const std::vector<std::string> keys{"format",  "version",      "id",           "folder", "instructions",
                                        "threads", "task_seconds", "join_seconds", "stages", "jobs"},
        of_jobs{"arguments", "division", "inputs",       "instance",
                "direct",    "parts",    "part_seconds", "part_bytes"};
    for (const std::string& key : keys)
        EXPECT_FALSE(bool(changed_plan([&](auto& json) { json.erase(key); }))) << key;
    for (const std::string& key : of_jobs)
        EXPECT_FALSE(bool(changed_plan([&](auto& json) { json["jobs"][2].erase(key); }))) << key;
    const std::string text = plan_text(example_plan());
    const TestFolder folder;
    for (std::size_t size = 0; size + 1 < text.size(); ++size) {
        write_text(folder / "plan.json", std::string_view(text).substr(0, size));
        EXPECT_FALSE(bool(read_plan(folder.path()))) << size << " bytes";
    }
}

TEST(FarmStatus, OpenTasksAreEstimatedFromFinishedOnesAndDividedAmongNodes) {
    const FarmPlan plan = example_plan();
    std::vector<TaskStatus> states(plan.task_count());
    const auto finish = [&](std::size_t task, double seconds, double cpu_seconds) {
        states[task].state = TaskState::done;
        states[task].cost.seconds = seconds;
        states[task].cost.cpu_seconds = cpu_seconds;
    };
    finish(0, 5, 4);    // samples: twice the estimate of 2.5 s
    finish(13, 10, 2);  // frames: four times
    std::vector<double> seconds = task_seconds(plan, states);
    EXPECT_EQ(seconds[1], 5);
    EXPECT_EQ(seconds[3], 2.5);
    EXPECT_EQ(seconds[12], 10);
    EXPECT_EQ(task_seconds(plan, states, TaskTime::processor)[1], 4);
    EXPECT_EQ(task_seconds(plan, states, TaskTime::processor)[12], 2);

    // The stages have 7, 10 and 1 tasks. Each stage takes at least as long as its longest task.
    seconds.assign(plan.task_count(), 2);
    const std::vector<bool> all(plan.task_count(), true);
    EXPECT_EQ(simulated_seconds(plan, seconds, all, 1, 0), 36);
    EXPECT_EQ(simulated_seconds(plan, seconds, all, 2, 0), 2 * (4 + 5 + 1));
    EXPECT_EQ(simulated_seconds(plan, seconds, all, 100, 0), 6);
    EXPECT_EQ(simulated_seconds(plan, seconds, all, 100, 1), 9);
    seconds[16] = 20;  // begins when a node is free
    EXPECT_EQ(simulated_seconds(plan, seconds, all, 3, 0), 2 * 3 + (2 * 3 + 20) + 2);
    std::vector<bool> left(plan.task_count(), false);
    left[17] = true;
    EXPECT_EQ(simulated_seconds(plan, seconds, left, 3, 0), 2);
}

TEST(TaskList, IsSortedUniqueAndShortest) {
    for (const auto& [text, shortest] :
         {std::pair("0", "0"), std::pair("0-9,12", "0-9,12"), std::pair("12,0-4,3-9,12-12", "0-9,12"),
          std::pair("1,2,3,5", "1-3,5"), std::pair("19,18", "18-19")}) {
        const Result<std::vector<std::size_t>> tasks = listed_tasks(text, 20);
        ASSERT_TRUE(tasks) << text << ": " << tasks.error().what;
        EXPECT_EQ(task_list(*tasks), shortest) << text;
    }
    EXPECT_EQ(task_list({}), "");
    EXPECT_EQ(listed_tasks("0-19,0-19,5-19,0-19,0-19,0-19", 20)->size(), 20u);
}

TEST(TaskList, InvalidTextsAndUnknownTasksAreRefused) {
    for (const char* text : {"", ",", "1,", ",1", "-", "1-", "-1", "1--2", "1-2-3", "a", "1 ", " 1", "+1",
                             "1.5", "0x1", "99999999999999999999"}) {
        EXPECT_FALSE(is_task_list(text)) << text;
        EXPECT_FALSE(listed_tasks(text, 20)) << text;
    }
    for (const auto& [text, reason] :
         {std::pair("20", "at most 19, the plan's last task"), std::pair("0-20", "is 20;"),
          std::pair("3-2", "the smaller number first"),
          std::pair("0-18446744073709551615", "at most 19, the plan's last task")}) {
        const Result<std::vector<std::size_t>> tasks = listed_tasks(text, 20);
        ASSERT_FALSE(tasks) << text;
        EXPECT_NE(tasks.error().what.find(reason), std::string::npos) << tasks.error().what;
    }
}

TEST(TaskBatches, ContainEachOpenTaskOnceByStageWithinTheLimit) {
    const FarmPlan plan = example_plan();
    std::vector<TaskStatus> states(plan.task_count());
    states[0].state = states[8].state = TaskState::done;
    states[1].state = TaskState::running;
    states[2].state = TaskState::damaged;
    states[3].state = TaskState::failed;
    const std::size_t in_stage[] = {5, 9, 1};
    for (const std::size_t least : {1, 2, 4, 100})
        for (const std::size_t most : {3, 4, 7, 15, 1000}) {
            const Result<std::vector<TaskBatch>> batches = task_batches(plan, states, least, most);
            ASSERT_TRUE(batches) << batches.error().what;
            EXPECT_LE(batches->size(), most);
            std::vector<std::size_t> tasks;
            for (const TaskBatch& batch : *batches) {
                for (const std::size_t task : batch.tasks) {
                    EXPECT_GE(task, plan.stages[batch.stage]);
                    EXPECT_LT(task, plan.stages[batch.stage + 1]);
                }
                EXPECT_LE(batch.tasks.size(), in_stage[batch.stage]);
                EXPECT_GT(batch.limits.minutes, 0);
                tasks.insert(tasks.end(), batch.tasks.begin(), batch.tasks.end());
            }
            EXPECT_GE(batches->front().tasks.size(), std::min<std::size_t>(least, 5));
            EXPECT_EQ(task_list(tasks), "2-7,9-17") << least << " " << most;
        }
    EXPECT_FALSE(task_batches(plan, states, 1, 2)) << "three stages";
}

TEST(FarmStatus, ResultsOfAWrongLengthOrChecksumAreDamaged) {
    const TestFolder folder;
    std::filesystem::create_directories(folder / "parts");
    const FarmPlan plan = example_plan();
    ASSERT_TRUE(
        write_part(folder.path(), plan, 2, {{1, 1, 1, "a"}, {{"x", std::string(5000, 'x')}, {"y", "y"}}}));
    const std::string whole = text_of(folder / "parts/2.part");
    const auto state = [&](const std::string& bytes, ResultCheck check) {
        write_text(folder / "parts/2.part", bytes);
        return task_states(folder.path(), plan, check)[2].state;
    };
    std::string changed = whole;
    changed[2500] ^= 1;
    for (const ResultCheck check : {ResultCheck::length, ResultCheck::content}) {
        EXPECT_EQ(state(whole, check), TaskState::done);
        for (const std::size_t size :
             {whole.size() - 1, whole.size() - 16, std::size_t(3000), std::size_t(1)})
            EXPECT_EQ(state(whole.substr(0, size), check), TaskState::damaged) << size;
        EXPECT_EQ(state("", check), TaskState::damaged);
        EXPECT_EQ(state(whole + "x", check), TaskState::damaged);
    }
    EXPECT_EQ(state(changed, ResultCheck::length), TaskState::done);
    EXPECT_EQ(state(changed, ResultCheck::content), TaskState::damaged);
}

// Results with valid checksums whose heads lack keys or have other types.
TEST(FarmPlan, UnknownHeadsOfResultsAreIgnored) {
    const TestFolder folder;
    std::filesystem::create_directories(folder / "parts");
    const FarmPlan plan = example_plan();
    const auto cost_of = [&](const std::string& head) {
        write_text(folder / "parts/2.part", section_file({{"task", head}}));
        return part_cost(folder.path(), plan, 2);
    };
    EXPECT_EQ(cost_of(R"({"plan":"0123","task":2,"seconds":1.5,"host":"a"})").value().seconds, 1.5);
    for (const char* head :
         {R"({"plan":"0123","task":2,"seconds":"long","cpu_seconds":null,"host":7,"peak_bytes":1e300})",
          R"({"plan":"0123","task":2,"seconds":-1,"peak_bytes":-1})"}) {
        const std::optional<TaskCost> cost = cost_of(head);
        ASSERT_TRUE(cost) << head;
        EXPECT_EQ(cost->seconds, 0);
        EXPECT_EQ(cost->peak_bytes, 0u);
        EXPECT_EQ(cost->host, "");
    }
    for (const char* head : {R"({"plan":5,"task":2})", R"({"plan":"0123","task":"2"})", R"({"plan":"0123"})",
                             R"({"plan":"0123","task":1})", "[]", ""})
        EXPECT_FALSE(cost_of(head)) << head;
}

}  // namespace
}  // namespace haarfield
