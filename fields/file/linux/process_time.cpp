#include "fields/file/process_time.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace haarfield {
namespace {

/// What /proc tells about a process.
struct ProcessStatus {
    pid_t process = 0, parent = 0;
    double seconds = 0;  ///< Of the process and of its children that have ended.
};

std::optional<ProcessStatus> status_of(pid_t process) {
    std::ifstream stream("/proc/" + std::to_string(process) + "/stat");
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const std::size_t name_end = text.rfind(')');  // a process's name may contain anything
    if (name_end == std::string::npos) return std::nullopt;
    std::istringstream words(text.substr(name_end + 1));
    std::string skipped;
    ProcessStatus status{process, 0, 0};
    words >> skipped >> status.parent;
    constexpr int words_between = 9, times = 4;
    for (int i = 0; i < words_between; ++i) words >> skipped;
    for (int i = 0; i < times; ++i) {
        double ticks = 0;
        words >> ticks;
        status.seconds += ticks / static_cast<double>(::sysconf(_SC_CLK_TCK));
    }
    if (!words) return std::nullopt;
    return status;
}

}  // namespace

std::optional<double> processor_seconds(pid_t process) {
    std::vector<ProcessStatus> all;
    std::error_code failure;
    for (const auto& entry : std::filesystem::directory_iterator("/proc", failure)) {
        const std::string name = entry.path().filename().string();
        pid_t number = 0;
        const auto [end, code] = std::from_chars(name.data(), name.data() + name.size(), number);
        if (code != std::errc() || end != name.data() + name.size()) continue;
        if (const auto status = status_of(number)) all.push_back(*status);
    }
    std::optional<double> seconds;
    std::vector<pid_t> family{process};
    for (std::size_t k = 0; k < family.size(); ++k)
        for (const ProcessStatus& status : all) {
            if (status.process == family[k]) seconds = seconds.value_or(0) + status.seconds;
            if (status.parent == family[k]) family.push_back(status.process);
        }
    return seconds;
}

}  // namespace haarfield
