#include <regex>

#include "tests/farm/farm_test.h"

namespace haarfield {
namespace {

/// The scripts of a plan, with stand-ins for Slurm's programs.
class FarmScripts : public FarmTest {
protected:
    void SetUp() override {
        std::filesystem::create_directory(folder / "bin");
        // Runs the job at once if a file `run_jobs` exists. Rejects calls from the number in `refuse` on.
        write_program("sbatch", R"sh(
echo "$*" >> calls
calls=$(wc -l < calls)
if [ -e refuse ] && [ "$calls" -ge "$(cat refuse)" ]; then
    echo "sbatch: error: Job violates accounting/QOS policy" >&2
    exit 1
fi
echo "$((100 + calls));cluster"
[ -e run_jobs ] || exit 0
first=0 last=0
for argument do
    case $argument in
        --array=*) indices=${argument#--array=}; first=${indices%%-*}; last=${indices#*-}; last=${last%%%*} ;;
        --*) ;;
        *) break ;;
    esac
    shift
done
for SLURM_ARRAY_TASK_ID in $(seq "$first" "$last"); do
    export SLURM_ARRAY_TASK_ID
    sh "$@" >> jobs.log 2>&1 || exit 1
done
)sh");
        write_program("scontrol", "cat config\n");
        write_program("squeue", "cat queue\n");
        write_program("scancel", "echo \"$*\" >> cancelled\n");
        write_text(folder / "config",
                   "Configuration data as of now\nMaxArraySize            = 4\n"
                   "MaxJobCount             = 40\n");
        write_text(folder / "queue", "");
        write_scene();
    }

    void write_program(const std::string& name, const std::string& script) {
        write_text(folder / ("bin/" + name), "#!/bin/sh\n" + script);
        std::filesystem::permissions(folder / ("bin/" + name), std::filesystem::perms::owner_all);
    }

    Outcome submit(const std::string& options = "") {
        return shell("PATH=$PWD/bin:$PATH sh plan/slurm.sh " + options);
    }

    /// Returns the calls of sbatch, one per line.
    std::vector<std::string> calls() const {
        std::istringstream lines(text_of(folder / "calls"));
        std::vector<std::string> calls;
        for (std::string line; std::getline(lines, line);) calls.push_back(line);
        return calls;
    }

    /// Returns the value of an option in a call.
    static std::string value(const std::string& call, const std::string& option) {
        std::smatch match;
        return std::regex_search(call, match, std::regex(" " + option + "=(\\S+)")) ? match[1].str() : "";
    }
};

TEST_F(FarmScripts, SubmitArraysWithinTheLimitsOfSlurm) {
    expect_done({"plan", "room.toml", "-o", "plan", "--tasks", "12", "--threads", "2", "--bake-options",
                 "--error off --face-size 16 --no-render"});
    ASSERT_EQ(task_count("plan"), 37u);
    write_text(folder / "queue", "7_1\n7_2\n8\n9\n");
    // For 24, 12 and 1 tasks with places for (40 - 4) * 9 / 10 - 1 = 31 jobs and the join: two tasks per job.
    for (const auto& [options, jobs] : {std::pair("", 12 + 6 + 1), std::pair("--most-jobs=15", 8 + 4 + 1),
                                        std::pair("--tasks-per-job=5", 5 + 3 + 1)}) {
        std::filesystem::remove(folder / "calls");
        const Outcome submitted = submit(options);
        ASSERT_EQ(submitted.code, 0) << submitted.err;
        int elements = 0;
        for (const std::string& call : calls()) {
            EXPECT_EQ(value(call, "--cpus-per-task"), "2");
            EXPECT_GE(std::stoi(value(call, "--time")), 10) << call;
            EXPECT_TRUE(std::regex_match(value(call, "--mem"), std::regex("[1-9][0-9]{2,3}M"))) << call;
            const std::string array = value(call, "--array");
            if (array.empty()) continue;
            EXPECT_EQ(array.substr(0, 2), "0-");
            EXPECT_LE(std::stoi(array.substr(2)), 3) << "Slurm's largest index";
            elements += std::stoi(array.substr(2)) + 1;
        }
        EXPECT_EQ(elements, jobs) << options;
        const std::string join = calls().back();
        EXPECT_EQ(value(join, "--array"), "");
        EXPECT_EQ(value(join, "--job-name"), "haarfield_join");
        EXPECT_NE(value(join, "--dependency").find("afterok:"), std::string::npos) << join;
        EXPECT_EQ(submitted.out, fmt::format("{}\n", 100 + calls().size())) << "the number of the join";
    }
    std::filesystem::remove(folder / "calls");
    EXPECT_EQ(submit("--at-once=2 --partition=night").code, 0);
    EXPECT_EQ(value(calls().front(), "--array"), "0-3%2");
    EXPECT_EQ(value(calls().back(), "--partition"), "night");
    EXPECT_NE(calls().front().find("/plan/logs/fields_%a.log"), std::string::npos) << calls().front();
    write_text(folder / "queue", std::string(2 * 40, '\n'));
    const Outcome full = submit();
    EXPECT_EQ(full.code, 1);
    EXPECT_NE(full.err.find("the queue is full"), std::string::npos) << full.err;
}

TEST_F(FarmScripts, ARefusedJobIsAnErrorAndTheOthersAreCancelled) {
    expect_done({"plan", "room.toml", "-o", "plan", "--tasks", "4", "--bake-options",
                 "--error off --face-size 16 --no-render"});
    for (const int refused : {1, 2, 4}) {
        std::filesystem::remove(folder / "calls");
        std::filesystem::remove(folder / "cancelled");
        write_text(folder / "refuse", std::to_string(refused));
        const Outcome submitted = submit();
        EXPECT_EQ(submitted.code, 1) << submitted.out;
        EXPECT_NE(submitted.err.find("QOS policy"), std::string::npos) << submitted.err;
        EXPECT_NE(submitted.err.find("sbatch refused the job"), std::string::npos) << submitted.err;
        EXPECT_EQ(calls().size(), std::size_t(refused)) << "nothing is submitted after a refusal";
        std::string cancelled;
        for (int job = 1; job < refused; ++job) cancelled += (job > 1 ? " " : "") + std::to_string(100 + job);
        EXPECT_EQ(text_of(folder / "cancelled"), cancelled.empty() ? "" : cancelled + "\n");
    }
}

TEST_F(FarmScripts, PassOnThatReadersMayBeUnsandboxed) {
    for (const bool unsandboxed : {false, true}) {
        std::vector<std::string> plan{"plan",    "room.toml", "-o", unsandboxed ? "trusted" : "plan",
                                      "--tasks", "2"};
        if (unsandboxed) plan.push_back("--unsandboxed");
        expect_done(plan);
        const std::string job = text_of(folder / plan[3] / "job.sh");
        EXPECT_EQ(job.find("\"$@\" --unsandboxed\n") != std::string::npos, unsandboxed) << job;
    }
}

TEST_F(FarmScripts, RunTheHookAndSubmitOnlyTasksWithoutAGoodResult) {
    expect_done({"bake", "room.toml", "-o", "whole", "--fields", "whole_fields", "--error", "off",
                 "--face-size", "16", "--no-render"});
    expect_done({"plan", "room.toml", "-o", "plan", "--tasks", "6", "--hook",
                 "echo hook >> '" + (folder / "hooks").string() + "'; run=env", "--bake-options",
                 "--error off --face-size 16 --no-render"});
    write_text(folder / "run_jobs", "");
    Outcome submitted = submit("--tasks-per-job=3");
    EXPECT_EQ(submitted.code, 0) << submitted.err << text_of(folder / "jobs.log");
    expect_same_files("plan/results/room", "whole");
    EXPECT_EQ(text_of(folder / "hooks"), "hook\nhook\nhook\nhook\nhook\nhook\nhook\nhook\n")
        << "four jobs of fields, two of direct light, one of indirect light, and the join";

    std::string bytes = text_of(folder / "plan/parts/3.part");
    bytes[bytes.size() / 2] ^= 1;
    write_text(folder / "plan/parts/3.part", bytes);
    for (const int lost : {4, 14}) std::filesystem::remove(folder / fmt::format("plan/parts/{}.part", lost));
    std::filesystem::remove(folder / "calls");
    std::filesystem::remove(folder / "jobs.log");
    submitted = submit();
    EXPECT_EQ(submitted.code, 0) << submitted.err << text_of(folder / "jobs.log");
    const std::string log = text_of(folder / "jobs.log");
    std::set<std::string> done;
    const std::regex line("task +(\\d+) done in");
    for (std::sregex_iterator match(log.begin(), log.end(), line), end; match != end; ++match)
        done.insert((*match)[1]);
    EXPECT_EQ(done, (std::set<std::string>{"3", "4", "14"})) << log;
    ASSERT_EQ(calls().size(), 3u);
    EXPECT_EQ(value(calls()[0], "--array"), "0-1");
    EXPECT_EQ(value(calls()[1], "--array"), "0-0");
    EXPECT_EQ(value(calls()[1], "--dependency"), "afterok:101");
    expect_done({"status", "plan", "--verify"});
}

TEST_F(FarmScripts, LimitsOfMemoryFollowFinishedTasks) {
    expect_done({"plan", "room.toml", "-o", "plan", "--tasks", "2", "--bake-options",
                 "--error off --face-size 16 --bounces 0 --no-render"});
    const auto megabytes = [&] {
        std::istringstream lines(run({"status", "plan", "--batches", "10"}).out);
        std::map<std::string, int> by_tasks;
        std::string stage, minutes, tasks;
        for (int value = 0; lines >> stage >> minutes >> value >> tasks;)
            by_tasks[stage + " " + tasks] = value;
        return by_tasks;
    };
    const auto before = megabytes();
    EXPECT_EQ(before.size(), 7u) << "six tasks and the join";
    expect_worked("plan", "0");
    const auto after = megabytes();
    EXPECT_FALSE(after.contains("1 0"));
    const double measured = 2e-6 * status("plan").value("peak_bytes", 0.0);
    EXPECT_NEAR(after.at("1 1"), measured, 1);
    EXPECT_NE(before.at("1 1"), after.at("1 1"));
    EXPECT_EQ(before.at("1 2"), after.at("1 2"));
    EXPECT_EQ(run({"status", "plan", "--batches", "1"}).code, 1) << "two stages";
}

}  // namespace
}  // namespace haarfield
