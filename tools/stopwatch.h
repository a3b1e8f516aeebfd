#pragma once
/// Times of work: on the clock, and of the processor.

#include <nlohmann/json_fwd.hpp>

#include <chrono>
#include <string>

namespace haarfield {

/// Durations of one piece of work. [s]
struct RunTime {
    double wall = 0;       ///< By the clock.
    double processor = 0;  ///< Of all threads of this process, without its child processes.

    RunTime& operator+=(const RunTime& other);
    RunTime operator-(const RunTime& other) const;
    RunTime operator/(double count) const;
};

/// Measures from its construction on.
class Stopwatch {
public:
    Stopwatch();
    RunTime elapsed() const;

private:
    std::chrono::steady_clock::time_point start_;
    double processor_start_;
};

/// Adds the keys `<name>_seconds` and `<name>_processor_seconds` to a report, without name and underscore if
/// the name is empty. Their ratio is the number of cores that were busy on average.
void report_time(nlohmann::ordered_json& report, const std::string& name, const RunTime& time);

}  // namespace haarfield
