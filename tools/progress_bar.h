#pragma once
/// Shows progress on stderr: a bar on a terminal, otherwise occasional lines.

#include "fields/base/progress.h"

#include <chrono>
#include <mutex>
#include <string>

namespace haarfield {

/// Returns one line about a stage: count, percentage, rate and remaining time, in at most `columns` columns.
/// On a terminal the line includes a bar.
std::string progress_line(std::string_view stage, std::uint64_t done, std::uint64_t total, double seconds,
                          bool with_bar, int columns);

/// Displays the stages of one command. Stages shorter than half a second are not displayed.
class ProgressBar {
public:
    explicit ProgressBar(bool quiet);
    ~ProgressBar() { clear(); }

    /// Implements Progress::report. Thread-safe.
    void report(std::string_view stage, std::uint64_t done, std::uint64_t total);

    /// Prints a line of text to stderr without colliding with the bar. Thread-safe.
    void message(const std::string& text);

private:
    using Clock = std::chrono::steady_clock;
    void clear();

    std::mutex mutex_;
    bool quiet_;
    bool terminal_;
    bool shown_ = false;  ///< True if a bar is on the terminal's last line.
    std::string stage_;
    Clock::time_point stage_start_, next_;
};

}  // namespace haarfield
