#include "fields/file/process_time.h"

#include "fields/file/linux/process_status.h"

#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace haarfield {
namespace {

/// A process, and the processor time of it and of its children that have ended.
struct ProcessTime {
    pid_t process = 0, parent = 0;
    double seconds = 0;
};

std::optional<ProcessTime> time_of(pid_t process) {
    const std::vector<std::string> status = process_status(process);
    constexpr std::size_t parent = 1, first_time = 11, times = 4;
    if (status.size() < first_time + times) return std::nullopt;
    ProcessTime result{process, static_cast<pid_t>(std::atol(status[parent].c_str())), 0};
    for (std::size_t k = first_time; k < first_time + times; ++k)
        result.seconds += std::atof(status[k].c_str()) / static_cast<double>(::sysconf(_SC_CLK_TCK));
    return result;
}

}  // namespace

std::optional<double> processor_seconds(pid_t process) {
    std::vector<ProcessTime> all;
    std::error_code failure;
    for (const auto& entry : std::filesystem::directory_iterator("/proc", failure)) {
        const std::string name = entry.path().filename().string();
        pid_t number = 0;
        const auto [end, code] = std::from_chars(name.data(), name.data() + name.size(), number);
        if (code != std::errc() || end != name.data() + name.size()) continue;
        if (const auto time = time_of(number)) all.push_back(*time);
    }
    std::optional<double> seconds;
    std::vector<pid_t> family{process};
    for (std::size_t k = 0; k < family.size(); ++k)
        for (const ProcessTime& time : all) {
            if (time.process == family[k]) seconds = seconds.value_or(0) + time.seconds;
            if (time.parent == family[k]) family.push_back(time.process);
        }
    return seconds;
}

}  // namespace haarfield
