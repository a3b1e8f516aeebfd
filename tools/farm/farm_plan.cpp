#include "tools/farm/farm_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "fields/base/exception_message.h"
#include "fields/base/range.h"
#include "fields/field/visibility_field.h"
#include "fields/file/mapped_file.h"
#include "tools/farm/plan_costs.h"

namespace haarfield {
namespace {

using nlohmann::ordered_json;

constexpr int format = 3;
constexpr std::array division_names{"samples", "shading", "strips",   "frames",
                                    "direct",  "bounces", "undivided"};

ordered_json job_json(const PlanJob& job) {
    ordered_json inputs = ordered_json::array();
    for (const PlanInput& input : job.inputs) inputs.push_back({{"file", input.file}, {"hash", input.hash}});
    return {{"arguments", job.arguments},
            {"division", division_names[static_cast<std::size_t>(job.division)]},
            {"inputs", inputs},
            {"instance", job.instance},
            {"direct", job.direct},
            {"parts", job.parts},
            {"part_seconds", job.part_seconds},
            {"part_bytes", job.part_bytes}};
}

[[noreturn]] void refuse(const std::string& key, const ordered_json& found, const std::string& wanted) {
    throw std::runtime_error(fmt::format("{} is {}; expected {}", key,
                                         found.is_number() ? found.dump() : found.type_name(), wanted));
}

std::size_t whole_number(const ordered_json& value, const char* key, std::size_t least, std::size_t most) {
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() < least ||
        value.get<std::uint64_t>() > most)
        refuse(key, value, fmt::format("a whole number in [{}, {}]", least, most));
    return value.get<std::size_t>();
}

double number(const ordered_json& json, const char* key, const char* unit) {
    constexpr Range all{0, 1e15};
    const ordered_json& value = json.at(key);
    if (!value.is_number() || !all.contains(value.get<double>()))
        refuse(key, value, fmt::format("{} in {}", unit, all.text()));
    return value.get<double>();
}

const ordered_json& list(const ordered_json& json, const char* key) {
    if (!json.at(key).is_array()) refuse(key, json.at(key), "a list");
    return json.at(key);
}

/// Returns a text value. Rejects zero characters, because they would end file names early.
std::string text(const ordered_json& value, const char* key) {
    if (!value.is_string()) refuse(key, value, "a text");
    auto text = value.get<std::string>();
    if (text.find('\0') != std::string::npos) refuse(key, value, "a text without zeros");
    return text;
}

std::string text_at(const ordered_json& json, const char* key) {
    return text(json.at(key), key);
}

PlanJob json_job(const ordered_json& json) {
    PlanJob job;
    for (const ordered_json& argument : list(json, "arguments"))
        job.arguments.push_back(text(argument, "arguments"));
    const std::optional<Division> division = possible_division(job.arguments);
    if (!division) throw std::runtime_error("a job has a command that plans do not support");
    const auto name = std::ranges::find(division_names, text_at(json, "division"));
    job.division = static_cast<Division>(name - division_names.begin());
    if (name == division_names.end() || !can_have(job.arguments, job.division))
        throw std::runtime_error(fmt::format("a {} has an unknown or unsupported division; expected {}",
                                             job.command(),
                                             division_names[static_cast<std::size_t>(*division)]));
    for (const ordered_json& input : list(json, "inputs"))
        job.inputs.push_back({text_at(input, "file"), text_at(input, "hash")});
    job.instance = whole_number(json.at("instance"), "instance", 0, 0xffffffff);
    job.direct = whole_number(json.at("direct"), "direct", 0, most_plan_tasks);
    const bool is_one = job.division == Division::undivided || job.division == Division::bounces;
    job.parts = whole_number(json.at("parts"), "parts", 1, is_one ? 1 : most_plan_tasks);
    if (job.division == Division::strips && job.parts % 2 != 0)
        refuse("parts", json.at("parts"), "an even number, because there are two sets of lights");
    job.part_seconds = number(json, "part_seconds", "seconds");
    job.part_bytes = number(json, "part_bytes", "bytes");
    return job;
}

FarmPlan json_plan(const ordered_json& json) {
    FarmPlan plan;
    plan.version = text_at(json, "version");
    plan.id = text_at(json, "id");
    plan.folder = text_at(json, "folder");
    plan.instructions = text_at(json, "instructions");
    plan.threads = static_cast<int>(whole_number(json.at("threads"), "threads", 1, 1024));
    plan.task_seconds = number(json, "task_seconds", "seconds");
    plan.join_seconds = number(json, "join_seconds", "seconds");
    std::size_t tasks = 0;
    for (const ordered_json& job : list(json, "jobs")) {
        PlanJob read = json_job(job);
        if (read.division == Division::bounces &&
            (read.direct >= plan.jobs.size() || plan.jobs[read.direct].division != Division::direct ||
             plan.jobs[read.direct].arguments != read.arguments))
            refuse("direct", job.at("direct"), "the earlier job with the direct light of the same bake");
        plan.jobs.push_back(std::move(read));
        tasks += plan.jobs.back().parts;
        if (tasks > most_plan_tasks)
            throw std::runtime_error(fmt::format("found more than {} tasks", most_plan_tasks));
    }
    const ordered_json& stages = list(json, "stages");
    if (stages.size() != plan.stages.size())
        throw std::runtime_error(
            fmt::format("found {} stages; expected {}", stages.size(), plan.stages.size()));
    for (std::size_t i = 0; i < stages.size(); ++i)
        plan.stages[i] = whole_number(stages[i], "stages",
                                      i + 1 == stages.size() ? tasks
                                      : i > 0                ? plan.stages[i - 1]
                                                             : 0,
                                      i == 0 ? 0 : tasks);
    if (tasks == 0) throw std::runtime_error("found no task");
    return plan;
}

}  // namespace

PlanTask FarmPlan::task(std::size_t number) const {
    for (std::size_t job = 0; job < jobs.size(); ++job) {
        if (number < jobs[job].parts) return {job, number};
        number -= jobs[job].parts;
    }
    assert(false);
    return {};
}

bool searches(const std::vector<std::string>& arguments) {
    return !arguments.empty() && arguments.front() == "bake" && !has_value(arguments, "--error", "off") &&
           !has_option(arguments, "--refine") && !has_option(arguments, "--original-vertices") &&
           !has_value(arguments, "--colours", "fitted") && !has_value(arguments, "--evaluator", "dense") &&
           !has_value(arguments, "--evaluator", "rays");
}

std::optional<Division> possible_division(const std::vector<std::string>& arguments) {
    const std::string command = arguments.empty() ? "" : arguments.front();
    if (command == "precompute") return Division::samples;
    if (command == "bake") {
        if (searches(arguments)) return Division::direct;
        if (has_option(arguments, "--refine")) return Division::undivided;
        if (option_number(arguments, "--bounces", 1) == 0) return Division::shading;
        // Fitting colours uses the indirect light, which needs the direct light of the whole scene first.
        return has_value(arguments, "--colours", "fitted") || has_value(arguments, "--evaluator", "dense") ||
                       has_value(arguments, "--evaluator", "rays")
                   ? Division::undivided
                   : Division::direct;
    }
    if (command == "reference")
        return !has_option(arguments, "--relative-error") && !has_option(arguments, "--radiosity")
                   ? Division::strips
                   : Division::undivided;
    if (command == "relight") return Division::frames;
    return std::nullopt;
}

bool can_have(const std::vector<std::string>& arguments, Division division) {
    const std::optional<Division> possible = possible_division(arguments);
    return possible == division || (possible == Division::direct &&
                                    (division == Division::bounces || division == Division::undivided));
}

std::size_t FarmPlan::first_task(std::size_t job) const {
    std::size_t first = 0;
    for (std::size_t before = 0; before < job; ++before) first += jobs[before].parts;
    return first;
}

Result<FarmPlan> read_plan(const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / "plan.json";
    HF_TRY(const MappedFile mapped, mapped_file(file));
    try {
        const ordered_json json = ordered_json::parse(mapped.bytes);
        // Plans of other versions may have a different structure, so the version is checked first.
        if (const ordered_json& found = json.at("format"); found != format)
            return Error{file.string(),
                         fmt::format("has format {}; expected {}",
                                     found.is_number() ? found.dump() : found.type_name(), format)};
        if (const std::string version = text_at(json, "version"); version != HAARFIELD_VERSION)
            return Error{file.string(),
                         fmt::format("is a plan of haarfield {}; expected {}", version, HAARFIELD_VERSION)};
        return json_plan(json);
    } catch (const std::exception& problem) {
        return Error{file.string(), fmt::format("is not a valid plan: {}", exception_message(problem))};
    }
}

std::string plan_text(const FarmPlan& plan) {
    ordered_json jobs = ordered_json::array();
    for (const PlanJob& job : plan.jobs) jobs.push_back(job_json(job));
    const ordered_json json{{"format", format},
                            {"version", plan.version},
                            {"id", plan.id},
                            {"folder", plan.folder},
                            {"instructions", plan.instructions},
                            {"threads", plan.threads},
                            {"task_seconds", plan.task_seconds},
                            {"join_seconds", plan.join_seconds},
                            {"stages", plan.stages},
                            {"jobs", jobs}};
    return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

Result<std::string> file_hash(const std::filesystem::path& file) {
    HF_TRY(const MappedFile mapped, mapped_file(file));
    return content_hash(mapped.bytes).hex();
}

Result<Done> check_inputs(const PlanJob& job) {
    for (const PlanInput& input : job.inputs) {
        HF_TRY(const std::string hash, file_hash(input.file));
        if (std::string_view(hash) != input.hash)
            return Error{input.file, "has changed since the plan was made; make a new plan"};
    }
    return Done{};
}

std::filesystem::path task_file(const std::filesystem::path& folder, std::size_t task, const char* ending) {
    return folder / "parts" / fmt::format("{}.{}", task, ending);
}

}  // namespace haarfield
