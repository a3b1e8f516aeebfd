#include "tools/farm/farm_plan.h"

#include <fmt/format.h>

#include <algorithm>

#include "fields/field/field_seal.h"
#include "fields/file/mapped_file.h"

namespace haarfield {
namespace {

using nlohmann::ordered_json;

constexpr int format = 1;
constexpr std::array division_names{"samples", "shading", "strips", "frames", "undivided"};

ordered_json job_json(const PlanJob& job) {
    ordered_json inputs = ordered_json::array();
    for (const PlanInput& input : job.inputs) inputs.push_back({{"file", input.file}, {"hash", input.hash}});
    return {
        {"arguments", job.arguments}, {"division", division_names[static_cast<std::size_t>(job.division)]},
        {"inputs", inputs},           {"instance", job.instance},
        {"parts", job.parts},         {"part_seconds", job.part_seconds}};
}

PlanJob json_job(const ordered_json& json) {
    PlanJob job;
    job.arguments = json.at("arguments").get<std::vector<std::string>>();
    const auto name = std::ranges::find(division_names, json.at("division").get<std::string>());
    if (job.arguments.empty() || name == division_names.end()) throw std::runtime_error("a job is none");
    job.division = static_cast<Division>(name - division_names.begin());
    for (const ordered_json& input : json.at("inputs"))
        job.inputs.push_back({input.at("file").get<std::string>(), input.at("hash").get<std::string>()});
    job.instance = json.at("instance").get<std::size_t>();
    job.parts = json.at("parts").get<std::size_t>();
    job.part_seconds = json.at("part_seconds").get<double>();
    return job;
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

std::size_t FarmPlan::first_task(std::size_t job) const {
    std::size_t first = 0;
    for (std::size_t before = 0; before < job; ++before) first += jobs[before].parts;
    return first;
}

Result<FarmPlan> read_plan(const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / "plan.json";
    const Result<MappedFile> mapped = mapped_file(file);
    if (!mapped) return mapped.error();
    try {
        const ordered_json json = ordered_json::parse(mapped->bytes);
        if (json.at("format").get<int>() != format)
            return Error{file.string(),
                         fmt::format("has format {}; wanted {}", json.at("format").dump(), format)};
        FarmPlan plan;
        plan.version = json.at("version").get<std::string>();
        plan.id = json.at("id").get<std::string>();
        plan.folder = json.at("folder").get<std::string>();
        plan.instructions = json.at("instructions").get<std::string>();
        plan.threads = json.at("threads").get<int>();
        plan.task_seconds = json.at("task_seconds").get<double>();
        for (const ordered_json& job : json.at("jobs")) plan.jobs.push_back(json_job(job));
        plan.stages = json.at("stages").get<std::array<std::size_t, 3>>();
        if (plan.version != HAARFIELD_VERSION)
            return Error{file.string(), fmt::format("is a plan of haarfield {}; this is {}", plan.version,
                                                    HAARFIELD_VERSION)};
        if (plan.first_task(plan.jobs.size()) != plan.task_count())
            return Error{file.string(), "has another number of tasks than its jobs"};
        return plan;
    } catch (const std::exception& problem) {
        return Error{file.string(), fmt::format("is no plan: {}", problem.what())};
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
                            {"stages", plan.stages},
                            {"jobs", jobs}};
    return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

Result<std::string> file_hash(const std::filesystem::path& file) {
    const Result<MappedFile> mapped = mapped_file(file);
    if (!mapped) return mapped.error();
    return content_hash(mapped->bytes).hex();
}

Result<Done> check_inputs(const PlanJob& job) {
    for (const PlanInput& input : job.inputs) {
        const Result<std::string> hash = file_hash(input.file);
        if (!hash) return hash.error();
        if (*hash != input.hash) return Error{input.file, "has changed since it was planned; plan it anew"};
    }
    return Done{};
}

std::filesystem::path task_file(const std::filesystem::path& folder, std::size_t task, const char* ending) {
    return folder / "parts" / fmt::format("{}.{}", task, ending);
}

}  // namespace haarfield
