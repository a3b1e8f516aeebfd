#include "fields/base/instruction_set.h"
#include "fields/base/names.h"
#include "fields/file/this_process.h"
#include "fields/file/write_file.h"
#include "tools/farm/job_run.h"
#include "tools/farm/plan_costs.h"
#include "tools/farm/plan_scripts.h"
#include "tools/farm/task_share.h"
#include "tools/number_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

namespace haarfield {

namespace {

struct PlanOptions {
    std::vector<std::string> scenes;
    std::string folder, output, fields, instructions, hook;
    std::vector<std::string> wanted{"bake"};
    std::string bake, reference, relight;  // further options of these commands
    double task_seconds = 300;
    int tasks = 0;  // of each divisible job; 0: determined by task_seconds
};

/// The data of a scene that planning needs.
struct PlannedScene {
    std::string file;  // absolute
    Scene scene;
    std::vector<PlanInput> inputs;
};

std::string absolute(const std::string& path) {
    return std::filesystem::absolute(path).lexically_normal().string();
}

/// Computes the hash of each file once.
class InputHashes {
public:
    Result<PlanInput> input(const std::filesystem::path& file) {
        const std::string name = absolute(file.string());
        const auto known = hashes_.find(name);
        if (known != hashes_.end()) return PlanInput{name, known->second};
        HF_TRY(const std::string hash, file_hash(name));
        hashes_[name] = hash;
        return PlanInput{name, hash};
    }

private:
    std::map<std::string, std::string> hashes_;
};

Result<PlannedScene> opened(const std::string& file, InputHashes& hashes) {
    SceneOptions options;
    options.scene = absolute(file);
    HF_TRY(Scene scene, opened_scene(options));
    std::set<std::filesystem::path> files{options.scene};
    std::set<std::size_t> entities;
    for (const Instance& instance : scene.instances) entities.insert(instance.entity);
    for (const std::size_t entity : entities) files.insert(scene.entities[entity].mesh);
    if (!scene.environment.image.empty()) files.insert(scene.environment.image);
    PlannedScene planned{options.scene, std::move(scene), {}};
    for (const std::filesystem::path& input : files) {
        HF_TRY(PlanInput hashed, hashes.input(input));
        planned.inputs.push_back(std::move(hashed));
    }
    return planned;
}

/// Sets the number of parts of a job, and the cost of each.
void divide(const JobCost& cost, std::size_t most, const PlanOptions& options, int threads, PlanJob& job) {
    const double whole = cost.work / threads, setup = cost.setup / threads;
    // Every part repeats the setup. Unless the number of parts is given, parts are so long that the setup
    // takes at most a tenth of their time.
    const double share = std::max(options.task_seconds - setup, 10 * setup);
    double parts = std::ceil(whole / std::max(share, 1e-3));
    if (options.tasks > 0) parts = options.tasks;
    job.parts = static_cast<std::size_t>(std::clamp(parts, 1.0, double(most)));
    job.part_seconds = setup + whole / double(job.parts);
    job.part_bytes = cost.bytes;
}

/// Adds the fields that jobs on a scene read, unless the plan has them already.
Result<Done> add_fields(const PlannedScene& planned, const std::vector<std::string>& arguments,
                        const PlanOptions& options, int threads, std::set<std::string>& known,
                        FarmPlan& plan) {
    HF_TRY(const JobOptions job_settings, job_options(arguments));
    const SceneEntityOptions& fields = job_settings.render.entities;
    const std::string folder = fields.fields_folder.string();
    std::vector<std::string> own{"precompute", planned.file, "-o", job_settings.output};
    if (!folder.empty()) own.insert(own.end(), {"--fields", folder});
    const std::vector<std::string> given =
        option_arguments(job_settings.render, {OptionSet::fields, OptionSet::vertices});
    own.insert(own.end(), given.begin(), given.end());
    for (std::size_t i = 0; i < planned.scene.instances.size(); ++i) {
        const Instance& instance = planned.scene.instances[i];
        const Entity& entity = planned.scene.entities[instance.entity];
        // Two names may denote the same field; then one task has nothing to do.
        const std::string name =
            fmt::format("{}\n{}\n{} {} {} {}\n{}\n{} {} {} {} {}", entity.mesh.string(), entity.part,
                        fields.original_vertices ? 0 : entity.fine_vertices, entity.coarse_triangles,
                        entity.planar_samples, entity.spherical_samples,
                        instance.shape == Shape() ? std::string() : shape_name(instance.shape), folder,
                        folder.empty() ? job_settings.output : "", fields.face_size, fields.coefficients,
                        fields.relative_l2_error);
        if (!known.insert(name).second) continue;
        PlanJob job;
        job.arguments = own;
        job.division = Division::samples;
        job.instance = i;
        for (const PlanInput& input : planned.inputs)
            if (input.file == planned.file || input.file == absolute(entity.mesh.string()))
                job.inputs.push_back(input);
        divide(field_cost(planned.scene, i), 100000, options, threads, job);
        plan.jobs.push_back(std::move(job));
    }
    return Done{};
}

/// Returns the environment images that the arguments name.
std::vector<std::string> files_in(const std::vector<std::string>& arguments) {
    std::vector<std::string> files;
    const auto add_list = [&](const std::string& list) {
        for (std::size_t first = 0; first <= list.size();) {
            const std::size_t end = std::min(list.find(',', first), list.size());
            files.push_back(list.substr(first, end - first));
            first = end + 1;
        }
    };
    const bool fades = arguments.front() == "relight";  // a reference's lights are a number
    for (std::size_t i = 0; i + 1 < arguments.size(); ++i) {
        if (arguments[i] == "--environment") files.push_back(arguments[i + 1]);
        if (fades && arguments[i] == "--lights") add_list(arguments[i + 1]);
    }
    return files;
}

/// Returns the jobs of a command: one with its division, followed by that of the bounces if it computes
/// direct light.
Result<std::vector<PlanJob>> command_jobs(const PlannedScene& planned, std::vector<std::string> arguments,
                                          const PlanOptions& options, int threads, InputHashes& hashes) {
    PlanJob job;
    const std::string command = arguments.front();
    if (Result<Done> good = check_arguments(arguments); !good)
        return Error{"--" + command + "-options", good.error().what};
    std::size_t most = 1;
    job.division = *possible_division(arguments);
    if (job.division == Division::shading || job.division == Division::direct) most = 100000;
    if (job.division == Division::strips) most = most_reference_parts(planned.scene.camera.height);
    if (job.division == Division::frames) {
        const double first = option_number(arguments, "--first-frame", 1),
                     last =
                         option_number(arguments, "--last-frame", option_number(arguments, "--frames", 48));
        most = static_cast<std::size_t>(std::max(1.0, last - first + 1));
    }
    const JobCost cost = command_cost(planned.scene, arguments);
    const JobCost remainder = remainder_cost(planned.scene, arguments);
    divide(cost, most, options, threads, job);
    if (job.division == Division::direct && job.parts == 1) {
        job.division = Division::undivided;
        divide({cost.setup, cost.work + remainder.work, remainder.bytes}, 1, options, threads, job);
    }
    if (job.division == Division::strips && job.parts % 2 == 1) ++job.parts;  // two sets of lights
    job.inputs = planned.inputs;
    for (const std::string& file : files_in(arguments)) {
        HF_TRY(PlanInput input, hashes.input(file));
        job.inputs.push_back(std::move(input));
    }
    job.arguments = std::move(arguments);
    std::vector<PlanJob> jobs{job};
    if (job.division != Division::direct) return jobs;
    job.division = Division::bounces;
    divide(remainder, 1, options, threads, job);
    jobs.push_back(std::move(job));
    return jobs;
}

std::string new_id() {
    std::random_device random;
    return fmt::format("{:08x}{:08x}", random(), random());
}

Result<FarmPlan> made_plan(const PlanOptions& options, CommandContext& context) {
    FarmPlan plan;
    plan.version = HAARFIELD_VERSION;
    plan.id = new_id();
    plan.folder = std::filesystem::current_path().string();
    plan.threads = context.threads;
    plan.task_seconds = options.task_seconds;
    const std::vector<std::string> sets = instruction_sets();
    plan.instructions = !options.instructions.empty() ? options.instructions
                        : sets.empty()                ? ""
                                                      : sets.front();
    HF_TRY_DONE(use_instruction_set(plan.instructions));

    const std::string fields =
        options.fields.empty() ? absolute(options.folder + "/fields") : absolute(options.fields);
    InputHashes hashes;
    std::set<std::string> known_fields, stems;
    std::vector<PlanJob> jobs, last_jobs;  // of the second and the third stage
    for (const std::string& file : options.scenes) {
        HF_TRY(const PlannedScene planned, opened(file, hashes));
        const std::string stem = unique_name(file_stem(planned.scene), stems);
        const std::string output =
            absolute((options.output.empty() ? options.folder + "/results" : options.output) + "/" + stem);
        for (const std::string& command : options.wanted) {
            const bool is_fields = command == "fields";
            const std::string& further = command == "bake"        ? options.bake
                                         : command == "reference" ? options.reference
                                         : is_fields              ? options.bake
                                                                  : options.relight;
            std::vector<std::string> arguments{is_fields ? "precompute" : command, planned.file, "-o",
                                               output};
            if (command != "reference") arguments.insert(arguments.end(), {"--fields", fields});
            for (std::string& word : CLI::detail::split_up(further)) arguments.push_back(std::move(word));
            if (command != "reference" && !searches(arguments))  // a search computes the samples that it uses
                HF_TRY_DONE(add_fields(planned, arguments, options, plan.threads, known_fields, plan));
            if (is_fields) continue;
            HF_TRY(std::vector<PlanJob> made,
                   command_jobs(planned, std::move(arguments), options, plan.threads, hashes));
            const JobCost join = join_cost(planned.scene, made.front().arguments);
            plan.join_seconds += (join.setup + join.work) / plan.threads;
            jobs.push_back(std::move(made.front()));
            if (made.size() > 1) last_jobs.push_back(std::move(made.back()));
        }
    }
    // References need no fields and start at once.
    const auto second = std::stable_partition(
        jobs.begin(), jobs.end(), [](const PlanJob& job) { return job.command() == "reference"; });
    std::move(jobs.begin(), second, std::back_inserter(plan.jobs));
    plan.stages[1] = plan.first_task(plan.jobs.size());
    std::move(second, jobs.end(), std::back_inserter(plan.jobs));
    plan.stages[2] = plan.first_task(plan.jobs.size());
    // The jobs have the order of their direct light.
    std::size_t direct = 0;
    for (PlanJob& job : last_jobs) {
        while (plan.jobs[direct].division != Division::direct) ++direct;
        job.direct = direct++;
        plan.jobs.push_back(std::move(job));
    }
    plan.stages[3] = plan.first_task(plan.jobs.size());
    return plan;
}

Result<ExitCode> run(const PlanOptions& options, CommandContext& context) {
    const std::filesystem::path folder = options.folder;
    std::error_code none;
    if (std::filesystem::exists(folder / "plan.json", none))
        return Error{(folder / "plan.json").string(), "exists already; expected a new folder for each plan"};
    HF_TRY(const FarmPlan plan, made_plan(options, context));
    if (plan.task_count() > most_plan_tasks)
        return Error{
            options.folder,
            fmt::format("would have {} tasks; expected at most {}: use longer tasks or several plans",
                        plan.task_count(), most_plan_tasks)};
    HF_TRY_DONE(make_folder(folder / "parts"));
    const ScriptPaths paths{running_program().string(), absolute(options.folder)};
    for (const auto& [name, text] :
         {std::pair("job.sh", job_script(plan, paths, options.hook, context.unsandboxed)),
          std::pair("slurm.sh", slurm_script(plan, paths)),
          std::pair("parallel.sh", parallel_script(plan, paths)), std::pair("plan.json", plan_text(plan))})
        HF_TRY_DONE(write_file(folder / name, text));
    double seconds = 0;
    for (const PlanJob& job : plan.jobs) seconds += job.part_seconds * double(job.parts);
    context.report["tasks"] = plan.task_count();
    context.report["jobs"] = plan.jobs.size();
    context.report["estimated_seconds"] = seconds;
    context.print("plan   {} tasks of {} jobs, about {:.3g} s each on {} threads with {}\n",
                  plan.task_count(), plan.jobs.size(),
                  plan.task_count() > 0 ? seconds / double(plan.task_count()) : 0.0, plan.threads,
                  plan.instructions);
    context.print("files  {0}/plan.json, {0}/slurm.sh, {0}/parallel.sh\n", options.folder);
    return ExitCode::done;
}

}  // namespace

Command plan_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand("plan", "Divide work into tasks for a scheduler");
    const auto options = std::make_shared<PlanOptions>();
    app->add_option("SCENE", options->scenes, "Scene files")->required()->type_name("");
    app->add_option("-o,--output", options->folder, "The plan's folder, which all machines must share")
        ->required()
        ->type_name("PLAN");
    app->add_option("--want", options->wanted, "Results to compute for each scene, separated by commas")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"fields", "bake", "reference", "relight"}))
        ->default_str("bake")
        ->type_name("WHAT,...");
    app->add_option("--bake-options", options->bake,
                    "Options of `bake` in one text; also used for the fields")
        ->type_name("TEXT");
    app->add_option("--reference-options", options->reference, "Options of `reference`")->type_name("TEXT");
    app->add_option("--relight-options", options->relight,
                    "Options of `relight`; --first-frame and --last-frame for a range")
        ->type_name("TEXT");
    app->add_option("--results", options->output,
                    "Folder for results, with a subfolder for each scene (default: results/ in the plan)")
        ->type_name("DIR");
    app->add_option("--fields", options->fields,
                    "Folder of the visibility fields (default: fields/ in the plan)")
        ->type_name("DIR");
    add_number(*app, "--task-seconds", options->task_seconds, "Intended time per task, by estimate", {1, 1e6})
        ->capture_default_str()
        ->type_name("S");
    add_number(*app, "--tasks", options->tasks,
               "Number of tasks per divisible job, instead of --task-seconds", {1, 1e5})
        ->type_name("N");
    app->add_option("--instructions", options->instructions,
                    "Vector instructions of all tasks on all machines: AVX2 if some machines have no AVX-512 "
                    "(default: the best instructions of this machine)")
        ->type_name("SET");
    app->add_option(
           "--hook", options->hook,
           "Shell line that each job runs first: 'module load povray', or run='apptainer exec IMAGE' "
           "to run haarfield in a container")
        ->type_name("LINE");
    app->footer(
        "--threads is the number of threads of each task. Fields are divided by samples, bakes by vertices,\n"
        "references by lights and rows, relights by frames. Indirect light is one task per bake, after the\n"
        "direct light, and so is the search of bakes with --error (the default). One task each: bakes with\n"
        "--refine, bakes with indirect light and --colours fitted, references with --relative-error or\n"
        "--radiosity.\n"
        "Example:\n  haarfield plan scenes/table_and_chairs.toml -o out/plan --want bake,reference --threads "
        "2\n"
        "  sh out/plan/parallel.sh --jobs 1    # or sh out/plan/slurm.sh");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
