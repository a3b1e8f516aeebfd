#include "tools/farm/task_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace haarfield {
namespace {

struct TaskRange {
    std::size_t first = 0, last = 0;
};

std::optional<std::size_t> number_in(std::string_view text) {
    std::size_t number = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

std::optional<std::vector<TaskRange>> ranges_in(std::string_view text) {
    std::vector<TaskRange> ranges;
    while (true) {
        const std::string_view range = text.substr(0, text.find(','));
        const std::size_t dash = range.find('-');
        const auto first = number_in(range.substr(0, dash)),
                   last = dash == std::string_view::npos ? first : number_in(range.substr(dash + 1));
        if (!first || !last) return std::nullopt;
        ranges.push_back({*first, *last});
        if (range.size() == text.size()) return ranges;
        text.remove_prefix(range.size() + 1);
    }
}

}  // namespace

bool is_task_list(std::string_view text) {
    return ranges_in(text).has_value();
}

Result<std::vector<std::size_t>> listed_tasks(std::string_view text, std::size_t count) {
    const auto ranges = ranges_in(text);
    if (!ranges) return Error{"", fmt::format("is {}; expected numbers and ranges, such as 0-9,12", text)};
    std::vector<std::size_t> tasks;
    for (const auto [first, last] : *ranges) {
        if (last < first)
            return Error{"", fmt::format("is {}-{}; expected the smaller number first", first, last)};
        if (last >= count)
            return Error{"",
                         fmt::format("is {}; expected at most {}, the plan's last task", last, count - 1)};
        for (std::size_t task = first; task <= last; ++task) tasks.push_back(task);
        // Overlapping ranges must not use more memory than the plan.
        if (tasks.size() > 2 * count) {
            std::ranges::sort(tasks);
            tasks.erase(std::unique(tasks.begin(), tasks.end()), tasks.end());
        }
    }
    std::ranges::sort(tasks);
    tasks.erase(std::unique(tasks.begin(), tasks.end()), tasks.end());
    return tasks;
}

std::string task_list(std::span<const std::size_t> tasks) {
    std::string list;
    for (std::size_t i = 0; i < tasks.size();) {
        std::size_t end = i + 1;
        while (end < tasks.size() && tasks[end] == tasks[end - 1] + 1) ++end;
        if (!list.empty()) list += ',';
        list += end - i == 1 ? fmt::format("{}", tasks[i]) : fmt::format("{}-{}", tasks[i], tasks[end - 1]);
        i = end;
    }
    return list;
}

}  // namespace haarfield
