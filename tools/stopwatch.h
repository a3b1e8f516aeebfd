#pragma once
/// Measures wall time and processor time.

#include <nlohmann/json_fwd.hpp>

#include <chrono>
#include <string>

namespace haarfield {

/// The time of one piece of work. [s]
struct RunTime {
    double wall = 0;       ///< Wall time.
    double processor = 0;  ///< Processor time of all threads of this process, without its child processes.

    RunTime& operator+=(const RunTime& other);
    RunTime operator-(const RunTime& other) const;
    RunTime operator/(double count) const;
};

/// Measures time from its construction on.
class Stopwatch {
public:
    Stopwatch();
    RunTime elapsed() const;

private:
    std::chrono::steady_clock::time_point start_;
    double processor_start_;
};

/// Adds the keys `<name>_seconds` and `<name>_processor_seconds` to a report; without `<name>_` if the name
/// is empty. The ratio of their values is the average number of busy cores.
void report_time(nlohmann::ordered_json& report, const std::string& name, const RunTime& time);

}  // namespace haarfield
