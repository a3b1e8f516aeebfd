#include "tests/fixtures/test_folder.h"
#include "tests/fuzz/json_changes.h"
#include "tests/fuzz/json_subjects.h"
#include "tests/fuzz/structured_changes.h"
#include "tools/farm/farm_status.h"
#include "tools/farm/job_run.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

using std::filesystem::path;

/// Returns the output of `plan` for a scene, with names and numbers that are the same each time.
std::string planned(const std::vector<std::string>& options) {
    const TestFolder folder;
    write_text(folder / "box.obj",
               "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n");
    write_text(folder / "room.toml",
               "[camera]\nposition = [2, 2, 3]\ntarget = [0, 0, 0]\nresolution = [96, 72]\n[environment]\n"
               "sky = { turbidity = 6, sun_elevation = 50 }\n[entities.box]\nmesh = \"box.obj\"\n"
               "[[instances]]\nentity = \"box\"\n[[instances]]\nentity = \"box\"\nscale = [1, 2, 1]\n");
    CLI::App program;
    Command command = plan_command(program);
    std::vector<std::string> arguments{"plan", folder / "room.toml", "-o", folder / "plan"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    program.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
    CommandContext context;
    context.threads = 2;
    context.quiet = true;
    if (!command.run(context)) abort();
    std::string text = text_of(folder / "plan/plan.json");
    const std::string place = folder.path().string();
    for (std::size_t at = 0; (at = text.find(place, at)) != std::string::npos;)
        text.replace(at, place.size(), "/rooms");
    auto json = nlohmann::ordered_json::parse(text);
    json["id"] = "0123456789abcdef";
    json["folder"] = "/rooms";
    json["instructions"] = "AVX2";
    return json.dump(1) + "\n";
}

/// Returns a defect of a parsed plan; empty if there is none.
std::string plan_defect(const FarmPlan& plan) {
    std::size_t tasks = 0;
    for (std::size_t number = 0; number < plan.jobs.size(); ++number) {
        const PlanJob& job = plan.jobs[number];
        if (job.arguments.empty() || !can_have(job.arguments, job.division))
            return "a job that is not divided as its command";
        const bool is_one = job.division == Division::undivided || job.division == Division::bounces;
        if (job.division == Division::bounces &&
            (job.direct >= number || plan.jobs[job.direct].division != Division::direct))
            return "bounces of no direct light";
        if (job.parts < 1 || (is_one && job.parts != 1) ||
            (job.division == Division::strips && job.parts % 2 != 0))
            return "a job in a wrong number of parts";
        if (plan.first_task(number) != tasks) return "a job that begins at another task";
        for (const std::size_t part : {std::size_t(0), job.parts - 1})
            if (const PlanTask task = plan.task(tasks + part); task.job != number || task.part != part)
                return "a task of another job";
        tasks += job.parts;
    }
    if (tasks < 1 || tasks > most_plan_tasks || plan.task_count() != tasks || plan.stages[0] != 0 ||
        !std::ranges::is_sorted(plan.stages))
        return "stages of other tasks than its jobs have";
    return plan.threads >= 1 && plan.threads <= 1024 ? "" : "a wrong number of threads";
}

class DamagedPlans : public Subject {
public:
    DamagedPlans()
        : plans_{
              planned({"--want", "fields,bake,reference,relight", "--bake-options", "--bounces 0", "--tasks",
                       "4", "--relight-options", "--spin-light --frames 9"}),
              planned({"--want", "bake,reference", "--tasks", "3", "--reference-options", "--radiosity"})} {}
    std::string file_name() const override { return "plan.json"; }
    std::string input(FuzzRandom& random) override {
        std::string text = plans_[random_index(random, plans_.size())];
        switch (random_index(random, 8)) {
            case 0:
                damage(text, random, plans_[random_index(random, plans_.size())], mesh_words());
                return text;
            case 1:
            case 2: change_structure(text, random, FileKind::text); return text;
            default: return changed_json(nlohmann::ordered_json::parse(text), random);
        }
    }
    std::string objection(const path& file, Outcome& outcome) override {
        const path folder = file.parent_path();
        const Result<FarmPlan> plan = read_plan(folder);
        if (!plan)
            return plan.error().where.empty() ? "refused without a place" : outcome.refused(plan.error());
        outcome.accepted = true;
        if (const std::string defect = plan_defect(*plan); !defect.empty()) return defect;
        // The further steps of `status`.
        const std::vector<double> seconds = task_seconds(*plan, task_states(folder, *plan));
        if (seconds.size() != plan->task_count()) return "tasks without an estimate";
        const std::vector<bool> left(seconds.size(), true);
        for (const std::size_t nodes : {1, 3, 1000})
            if (const double simulated = simulated_seconds(*plan, seconds, left, nodes, 1);
                !(simulated >= 0 && std::isfinite(simulated)))
                return "a time that is no number";
        // The checks of `work` and `join`.
        for (const PlanJob& job : plan->jobs) {
            if (const Result<Done> same = check_inputs(job); !same && same.error().what.empty())
                return "an input was refused without a reason";
            if (const Result<Done> good = check_arguments(job.arguments); !good && good.error().what.empty())
                return "arguments were refused without a reason";
            if (const Result<JobOptions> options = job_options(job.arguments);
                !options && options.error().what.empty())
                return "options were refused without a reason";
        }
        const std::string text = plan_text(*plan);
        write_text(file, text);
        const Result<FarmPlan> again = read_plan(folder);
        return again && plan_text(*again) == text ? "" : "another plan once written and read";
    }

private:
    std::vector<std::string> plans_;
};

}  // namespace

std::unique_ptr<Subject> damaged_plans() {
    return std::make_unique<DamagedPlans>();
}

}  // namespace haarfield
