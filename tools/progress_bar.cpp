#include "tools/progress_bar.h"

#include "tools/print_text.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace haarfield {

namespace {

constexpr auto first_after = std::chrono::milliseconds(500);
constexpr auto bar_period = std::chrono::milliseconds(100);
constexpr auto line_period = std::chrono::seconds(3);

// Formats rates and counts with three or four digits.
std::string short_number(double number) {
    if (number >= 1e9) return fmt::format("{:.1f}G", number / 1e9);
    if (number >= 1e6) return fmt::format("{:.1f}M", number / 1e6);
    if (number >= 1e4) return fmt::format("{:.0f}k", number / 1e3);
    if (number >= 10 || number == 0) return fmt::format("{:.0f}", number);
    return fmt::format("{:.1f}", number);
}

std::string duration(double seconds) {
    const auto whole = static_cast<std::uint64_t>(std::min(seconds + 0.5, 3.6e6));
    if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

bool is_terminal() {
    const char* kind = std::getenv("TERM");
    return isatty(STDERR_FILENO) == 1 && kind != nullptr && std::string_view(kind) != "dumb";
}

int terminal_columns() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

std::string progress_line(std::string_view stage, std::uint64_t done, std::uint64_t total, double seconds,
                          bool with_bar, int columns) {
    const double share =
        total == 0 ? 1.0 : std::min(1.0, static_cast<double>(done) / static_cast<double>(total));
    const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
    std::string numbers = fmt::format("{:3.0f} %  {}/{}", 100 * share, done, total);
    if (rate > 0)
        numbers += fmt::format("  {}/s  {} left", short_number(rate),
                               duration(static_cast<double>(std::max(total, done) - done) / rate));
    std::string name(stage);
    if (with_bar) {
        const int room = columns - 1 - 24 - 2 - static_cast<int>(numbers.size()) - 2;
        if (room >= 8) {
            const auto width = static_cast<std::size_t>(std::min(room, 40));
            const auto full = static_cast<std::size_t>(share * static_cast<double>(width));
            numbers =
                fmt::format("[{}{}] {}", std::string(full, '='), std::string(width - full, ' '), numbers);
        }
        name = fmt::format("{:<24}", name);
    }
    std::string line = fmt::format("{}  {}", name, numbers);
    if (columns > 0 && line.size() >= static_cast<std::size_t>(columns))
        line.resize(static_cast<std::size_t>(columns) - 1);
    return line;
}

ProgressBar::ProgressBar(bool quiet) : quiet_(quiet), terminal_(is_terminal()) {}

void ProgressBar::report(std::string_view stage, std::uint64_t done, std::uint64_t total) {
    if (quiet_) return;
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (stage != stage_) {
        clear();
        stage_ = stage;
        stage_start_ = now;
        next_ = now + first_after;
    }
    if (now < next_) return;
    next_ = now + (terminal_ ? Clock::duration(bar_period) : Clock::duration(line_period));
    const double seconds = std::chrono::duration<double>(now - stage_start_).count();
    if (terminal_) {
        const std::string line = progress_line(stage, done, total, seconds, true, terminal_columns());
        print(stderr, "\r{}\x1b[K", line);
        shown_ = true;
    } else {
        print(stderr, "{}\n", progress_line(stage, done, total, seconds, false, 0));
    }
    std::fflush(stderr);
}

void ProgressBar::message(const std::string& text) {
    const std::lock_guard lock(mutex_);
    clear();
    print(stderr, "{}\n", text);
}

void ProgressBar::clear() {
    if (shown_) print(stderr, "\r\x1b[K");
    shown_ = false;
}

}  // namespace haarfield
