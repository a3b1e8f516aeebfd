#pragma once
/// How far the work is, on stderr: a bar on a terminal, else now and then a line.

#include "fields/base/progress.h"

#include <chrono>
#include <mutex>
#include <string>

namespace haarfield {

/// One line about a stage: count, share, rate and time left, in at most `columns` columns. On a terminal
/// the line has a bar.
std::string progress_line(std::string_view stage, std::uint64_t done, std::uint64_t total, double seconds,
                          bool with_bar, int columns);

/// Shows the stages of one command. Stages shorter than half a second are not shown.
class ProgressBar {
public:
    explicit ProgressBar(bool quiet);
    ~ProgressBar() { clear(); }

    /// What Progress::report wants. From any thread.
    void report(std::string_view stage, std::uint64_t done, std::uint64_t total);

    /// A line of text for stderr that does not collide with the bar.
    void message(const std::string& text);

private:
    using Clock = std::chrono::steady_clock;
    void clear();

    std::mutex mutex_;
    bool quiet_;
    bool terminal_;
    bool shown_ = false;  ///< Whether a bar is on the terminal's last line.
    std::string stage_;
    Clock::time_point stage_start_, next_;
};

}  // namespace haarfield
