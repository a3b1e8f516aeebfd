#include "tools/farm/task_part.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "fields/file/mapped_file.h"
#include "fields/file/temporary_file.h"
#include "fields/file/write_file.h"

namespace haarfield {
namespace {

using nlohmann::ordered_json;

constexpr std::string_view file_prefix = "file ";

/// Returns a non-negative number, or 0 if the key has none.
double seconds_in(const ordered_json& json, const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number() ? std::max(0.0, found->get<double>()) : 0;
}

bool is_at(const ordered_json& json, const char* key, const ordered_json& wanted) {
    const auto found = json.find(key);
    return found != json.end() && *found == wanted;
}

/// Returns the cost if the section is the head of this task's part.
std::optional<TaskCost> head_cost(const Section& head, const FarmPlan& plan, std::size_t task) {
    const ordered_json json = ordered_json::parse(head.bytes, nullptr, /*allow_exceptions=*/false);
    if (head.name != "task" || !json.is_object() || !is_at(json, "plan", plan.id) ||
        !is_at(json, "task", task))
        return std::nullopt;
    TaskCost cost{seconds_in(json, "seconds"), seconds_in(json, "cpu_seconds"), 0, {}};
    if (const auto peak = json.find("peak_bytes"); peak != json.end() && peak->is_number_unsigned())
        cost.peak_bytes = peak->get<std::uint64_t>();
    if (const auto host = json.find("host"); host != json.end() && host->is_string())
        cost.host = host->get<std::string>();
    return cost;
}

double seconds_of(const timeval& time) {
    return double(time.tv_sec) + 1e-6 * double(time.tv_usec);
}

}  // namespace

Result<Done> write_part(const std::filesystem::path& folder, const FarmPlan& plan, std::size_t task,
                        const TaskPart& part) {
    const ordered_json head{{"plan", plan.id},
                            {"task", task},
                            {"seconds", part.cost.seconds},
                            {"cpu_seconds", part.cost.cpu_seconds},
                            {"peak_bytes", part.cost.peak_bytes},
                            {"host", part.cost.host}};
    std::vector<Section> sections{
        {"task", head.dump(-1, ' ', false, ordered_json::error_handler_t::replace)}};
    sections.insert(sections.end(), part.sections.begin(), part.sections.end());
    const std::string bytes = section_file(sections);
    HF_TRY(TemporaryFile temporary, TemporaryFile::beside(task_file(folder, task, "part")));
    HF_TRY_DONE(temporary.write(bytes));
    return temporary.replace_target(bytes);
}

Result<TaskPart> read_part(const std::filesystem::path& folder, const FarmPlan& plan, std::size_t task) {
    const std::filesystem::path file = task_file(folder, task, "part");
    HF_TRY(std::vector<Section> sections, read_section_file(file));
    const std::optional<TaskCost> cost =
        sections.empty() ? std::nullopt : head_cost(sections.front(), plan, task);
    if (!cost) return Error{file.string(), "is the result of another task or another plan"};
    sections.erase(sections.begin());
    return TaskPart{*cost, std::move(sections)};
}

std::optional<TaskCost> part_cost(const std::filesystem::path& folder, const FarmPlan& plan,
                                  std::size_t task) {
    const std::filesystem::path file = task_file(folder, task, "part");
    std::error_code none;
    if (!std::filesystem::exists(file, none)) return std::nullopt;
    const Result<Section> head = read_first_section(file);
    return head ? head_cost(*head, plan, task) : std::nullopt;
}

TaskCost process_cost(double seconds) {
    TaskCost cost{seconds, 0, 0, {}};
    for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
        rusage usage{};
        getrusage(who, &usage);
        cost.cpu_seconds += seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
        cost.peak_bytes = std::max(cost.peak_bytes, std::uint64_t(usage.ru_maxrss) * 1024);
    }
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    // Several Slurm nodes can run on one machine.
    const char* const node = std::getenv("SLURMD_NODENAME");
    cost.host = node ? node : host.data();
    return cost;
}

Result<std::vector<Section>> file_sections(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code failed;
    for (std::filesystem::recursive_directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed))
        if (entry->is_regular_file()) files.push_back(entry->path());
    if (failed) return Error{folder.string(), failed.message()};
    std::ranges::sort(files);
    std::vector<Section> sections;
    for (const std::filesystem::path& file : files) {
        HF_TRY(const MappedFile mapped, mapped_file(file));
        sections.push_back({std::string(file_prefix) + file.lexically_relative(folder).generic_string(),
                            std::string(mapped.bytes)});
    }
    return sections;
}

Result<Done> write_file_sections(const std::vector<Section>& sections, const std::filesystem::path& folder) {
    for (const Section& section : sections) {
        if (!section.name.starts_with(file_prefix)) continue;
        const std::filesystem::path name =
            std::filesystem::path(section.name.substr(file_prefix.size())).lexically_normal();
        if (name.empty() || name.is_absolute() || *name.begin() == "..")
            return Error{section.name, "is outside of the results folder; expected a path below it"};
        const std::filesystem::path file = folder / name;
        HF_TRY_DONE(make_folder(file.parent_path()));
        HF_TRY_DONE(write_file(file, section.bytes));
    }
    return Done{};
}

}  // namespace haarfield
