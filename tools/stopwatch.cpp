#include "tools/stopwatch.h"

#include <nlohmann/json.hpp>

#include <ctime>

namespace haarfield {
namespace {

double processor_seconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

}  // namespace

RunTime& RunTime::operator+=(const RunTime& other) {
    wall += other.wall;
    processor += other.processor;
    return *this;
}

RunTime RunTime::operator-(const RunTime& other) const {
    return {wall - other.wall, processor - other.processor};
}

RunTime RunTime::operator/(double count) const {
    return {wall / count, processor / count};
}

Stopwatch::Stopwatch() : start_(std::chrono::steady_clock::now()), processor_start_(processor_seconds()) {}

RunTime Stopwatch::elapsed() const {
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(),
            processor_seconds() - processor_start_};
}

void report_time(nlohmann::ordered_json& report, const std::string& name, const RunTime& time) {
    const std::string prefix = name.empty() ? "" : name + "_";
    report[prefix + "seconds"] = time.wall;
    report[prefix + "processor_seconds"] = time.processor;
}

}  // namespace haarfield
