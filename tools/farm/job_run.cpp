#include "tools/farm/job_run.h"

#include <unistd.h>

#include <algorithm>
#include <optional>

#include "fields/base/instruction_set.h"
#include "fields/field/field_library.h"
#include "fields/field/sample_run.h"
#include "fields/file/process_name.h"
#include "fields/file/write_file.h"
#include "scenes/entity_field.h"
#include "tools/farm/task_share.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace haarfield {
namespace {

/// Parses arguments and passes the parsed command to `use`.
template <class Use>
auto with_command(const std::vector<std::string>& arguments, const Use& use)
    -> decltype(use(std::declval<Command&>())) {
    CLI::App program{"", "haarfield"};
    std::vector<Command> commands;
    CommonOptions common;
    for (const auto make : {precompute_command, bake_command, reference_command, relight_command}) {
        commands.push_back(make(program));
        add_common_options(*commands.back().app, common);
    }
    program.require_subcommand(1);
    try {
        std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
        program.parse(std::move(reversed));
    } catch (const CLI::ParseError& error) {
        return Error{"", error.what()};
    }
    const auto parsed = std::ranges::find_if(commands, [](const Command& c) { return c.app->parsed(); });
    return use(*parsed);
}

/// Runs the command of a job, or its share of it.
Result<Done> run_job(const std::vector<std::string>& arguments, TaskShare* share, CommandContext& context) {
    return with_command(arguments, [&](Command& command) -> Result<Done> {
        context.share = share;
        const Result<ExitCode> code = command.run(context);
        context.share = nullptr;
        if (!code) return code.error();
        return Done{};
    });
}

/// Returns the arguments with another output folder.
std::vector<std::string> with_output(std::vector<std::string> arguments, const std::string& folder) {
    for (std::size_t i = 0; i + 1 < arguments.size(); ++i)
        if (arguments[i] == "-o") arguments[i + 1] = folder;
    return arguments;
}

/// A scratch folder of one process, removed afterwards. The constructor also removes folders of processes
/// that have ended.
class ScratchFolder {
public:
    explicit ScratchFolder(const std::filesystem::path& plan) : path_(plan / "scratch" / process_name()) {
        std::error_code ignored;
        for (std::filesystem::directory_iterator entry(plan / "scratch", ignored), end; entry != end;
             entry.increment(ignored))
            if (process_liveness(entry->path().filename().string()) == Liveness::ended)
                std::filesystem::remove_all(entry->path(), ignored);
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    ~ScratchFolder() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

/// The entity and the settings of a job that computes a field.
struct FieldJob {
    SceneEntities entities;  // exactly one
    FieldSettings settings;
    FieldKeys keys;
    std::filesystem::path library;

    const SceneEntity& entity() const { return *entities.entities.front(); }
};

Result<FieldJob> opened_field_job(const PlanJob& job, const Progress& progress) {
    HF_TRY(const JobOptions options, job_options(job.arguments));
    HF_TRY(Scene scene, opened_scene(options.scene));
    if (job.instance >= scene.instances.size())
        return Error{options.scene.scene, "has fewer instances than when the plan was made"};
    const Instance instance = scene.instances[job.instance];
    scene.instances = {instance};
    scene.keyframes.clear();
    SceneEntityOptions wanted = entity_options(options.render, options.output);
    FieldJob field;
    field.library = wanted.fields_folder;
    wanted.fields = FieldExtent::none;
    HF_TRY(field.entities, prepare_scene_entities(scene, wanted, progress));
    field.settings =
        entity_field_settings(scene.entities[instance.entity], *field.entity().occlusion, wanted);
    field.keys = field_keys(field.entity().mesh, field.settings);
    return field;
}

/// Adds a field to its library. Samples that are not known are computed.
Result<Done> add_field(const FieldJob& field, std::span<const SampleRun> known, const Progress& progress) {
    const SceneEntity& entity = field.entity();
    HF_TRY_DONE(make_folder(field.library));
    HF_TRY_DONE(library_field(
        field.library, entity.name, field.keys,
        [&](const PrecomputedSamples& surroundings) {
            PrecomputedSamples all = surroundings;
            if (!known.empty()) all.runs = known;
            return precompute_field(entity.name, entity.mesh, *entity.occlusion, field.settings, progress,
                                    all);
        },
        progress));
    return Done{};
}

constexpr const char* in_library = "the library has the field";

/// Appends the samples of a part. A part that states that the library has the field has no samples.
Result<Done> add_run(const FieldJob& field, const std::vector<Section>& part, std::vector<SampleRun>& runs) {
    if (section_named(part, in_library)) return Done{};
    HF_TRY(SampleRun run, sections_samples(part, field.keys));
    runs.push_back(std::move(run));
    return Done{};
}

/// Adds a field to its library if all parts of its job exist. `join` reports damaged parts.
///
/// made  the samples of these tasks' parts, which are not published yet.
Result<Done> add_finished_field(const FarmPlan& plan, const PlanTasks& tasks, const FieldJob& field,
                                std::vector<SampleRun> made, const std::filesystem::path& folder,
                                const Progress& progress) {
    const std::size_t parts = plan.jobs[tasks.job].parts, first = plan.first_task(tasks.job);
    const auto is_made = [&](std::size_t part) {
        return part >= tasks.part && part < tasks.part + tasks.count;
    };
    std::error_code none;
    for (std::size_t part = 0; part < parts; ++part)
        if (!is_made(part) && !std::filesystem::exists(task_file(folder, first + part, "part"), none))
            return Done{};
    std::vector<SampleRun> runs;
    for (std::size_t part = 0; part < parts; ++part) {
        if (is_made(part)) {
            runs.push_back(std::move(made[part - tasks.part]));
            continue;
        }
        const Result<TaskPart> other = read_part(folder, plan, first + part);
        if (!other || !add_run(field, other->sections, runs)) return Done{};
    }
    return add_field(field, runs, progress);
}

Result<PartSections> done_samples(const FarmPlan& plan, const PlanTasks& tasks,
                                  const std::filesystem::path& folder, CommandContext& context) {
    const PlanJob& job = plan.jobs[tasks.job];
    HF_TRY(const FieldJob field, opened_field_job(job, context.progress));
    if (has_library_field(field.library, field.keys))
        return PartSections(tasks.count, std::vector<Section>{{in_library, {}}});
    const SceneEntity& entity = field.entity();
    const std::uint64_t count = sample_count(entity.mesh, field.settings);
    PartSections made;
    std::vector<SampleRun> runs;
    for (std::size_t part = tasks.part; part < tasks.part + tasks.count; ++part) {
        const auto [begin, end] = items_of_parts(count, part, 1, job.parts);
        HF_TRY(SampleRun run, field_samples(entity.name, entity.mesh, *entity.occlusion, field.settings,
                                            begin, end, context.progress));
        made.push_back(sample_sections(run, field.keys));
        runs.push_back(std::move(run));
    }
    // The task that computes the last part joins the field, so that the next stage finds it.
    HF_TRY_DONE(add_finished_field(plan, tasks, field, std::move(runs), folder, context.progress));
    return made;
}

/// Returns the parts of a job; empty for missing or damaged parts.
std::vector<std::vector<Section>> good_parts(const FarmPlan& plan, std::size_t job,
                                             const std::filesystem::path& folder) {
    std::vector<std::vector<Section>> parts(plan.jobs[job].parts);
    for (std::size_t part = 0; part < parts.size(); ++part)
        if (Result<TaskPart> read = read_part(folder, plan, plan.first_task(job) + part))
            parts[part] = std::move(read->sections);
    return parts;
}

}  // namespace

Result<JobOptions> job_options(const std::vector<std::string>& arguments) {
    CLI::App app;
    JobOptions options;
    app.allow_extras();
    add_scene_option(app, options.scene);
    add_render_options(app, options.render, {OptionSet::vertices});
    add_field_options(app, options.render);
    app.add_option("-o,--output", options.output);
    try {
        app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend() - 1));
    } catch (const CLI::ParseError& error) {
        return Error{"", error.what()};
    }
    return options;
}

Result<Done> check_arguments(const std::vector<std::string>& arguments) {
    return with_command(arguments, [](Command&) { return Result<Done>(Done{}); });
}

Result<Done> enter_plan(const FarmPlan& plan) {
    std::error_code failed;
    std::filesystem::current_path(plan.folder, failed);
    if (failed)
        return Error{plan.folder,
                     "the plan was made in this folder, which cannot be entered: " + failed.message()};
    return use_instruction_set(plan.instructions);
}

Result<PartSections> done_tasks(const FarmPlan& plan, const PlanTasks& tasks,
                                const std::filesystem::path& folder, CommandContext& context) {
    const PlanJob& job = plan.jobs[tasks.job];
    if (job.division == Division::samples) return done_samples(plan, tasks, folder, context);
    TaskShare share(tasks.part, tasks.count, job.parts);
    if (job.division == Division::bounces) {
        share.joins = true;
        share.joined = good_parts(plan, job.direct, folder);
        share.parts = share.joined.size();
    }
    // A killed task leaves nothing among the results.
    const ScratchFolder scratch(folder);
    const std::filesystem::path output = scratch.path() / "results";
    HF_TRY_DONE(make_folder(output));
    TaskShare* const divided = job.division == Division::undivided ? nullptr : &share;
    HF_TRY_DONE(run_job(with_output(job.arguments, output.string()), divided, context));
    if (job.division == Division::shading || job.division == Division::direct ||
        job.division == Division::strips)
        return std::move(share.made);
    PartSections made;
    for (std::size_t k = 0; k < tasks.count; ++k) {
        const bool has_folder = job.division == Division::frames;
        HF_TRY(std::vector<Section> files, file_sections(has_folder ? output / part_folder(k) : output));
        made.push_back(std::move(files));
    }
    return made;
}

Result<Done> join_job(const FarmPlan& plan, std::size_t number, const std::filesystem::path& folder,
                      CommandContext& context) {
    const PlanJob& job = plan.jobs[number];
    if (job.division == Division::direct) return Done{};  // the job of its bounces has the complete result
    const auto part_of = [&](std::size_t part) {
        return read_part(folder, plan, plan.first_task(number) + part);
    };
    if (job.division == Division::samples) {
        HF_TRY(const FieldJob field, opened_field_job(job, context.progress));
        // The process that computed the last part has already added the field.
        if (has_library_field(field.library, field.keys)) return Done{};
        std::vector<SampleRun> runs;
        for (std::size_t part = 0; part < job.parts; ++part) {
            HF_TRY(const TaskPart read, part_of(part));
            HF_TRY_DONE(add_run(field, read.sections, runs));
        }
        return add_field(field, runs, context.progress);
    }
    const bool is_done = job.division == Division::undivided || job.division == Division::bounces,
               has_files = is_done || job.division == Division::frames;
    HF_TRY(const JobOptions options, job_options(job.arguments));
    TaskShare share(0, 0, job.parts);
    share.joins = true;
    for (std::size_t part = 0; part < job.parts; ++part) {
        HF_TRY(TaskPart read, part_of(part));
        if (!has_files)
            share.joined.push_back(std::move(read.sections));
        else
            HF_TRY_DONE(write_file_sections(read.sections, options.output));
    }
    return is_done ? Done{} : run_job(job.arguments, &share, context);
}

}  // namespace haarfield
