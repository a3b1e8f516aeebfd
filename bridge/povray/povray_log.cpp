#include "bridge/povray/povray_log.h"

#include <algorithm>

namespace haarfield {
namespace {

std::vector<std::string> lines_of(const std::string& log) {
    std::vector<std::string> lines(1);
    for (char c : log)
        if (c == '\n' || c == '\r')
            lines.emplace_back();
        else
            lines.back() += c;
    return lines;
}

}  // namespace

std::vector<std::string> povray_messages(const std::string& log) {
    static constexpr const char* starts[] = {"File '", "Possible ", "Parse ",  "Warning", "Fatal",
                                             "Render", "Error",     "Problem", "POV-Ray", "----",
                                             "====",   "povray:",   "Failed"};
    std::vector<std::string> result;
    bool open = false;
    for (const std::string& line : lines_of(log)) {
        const bool is_start = std::any_of(std::begin(starts), std::end(starts),
                                          [&](const char* start) { return line.rfind(start, 0) == 0; });
        if (is_start)
            result.push_back(line);
        else if (open && !line.empty())
            result.back() += line;
        open = is_start || (open && !line.empty());
    }
    return result;
}

bool mentions(const std::string& message, const char* text) {
    return message.find(text) != std::string::npos;
}

std::string povray_failure(const std::string& log) {
    std::string words, last;
    for (const std::string& message : povray_messages(log)) {
        if (mentions(message, "cannot open the user configuration")) continue;  // every run prints it
        if (mentions(message, "Error:") || mentions(message, "Failed") || mentions(message, "rror in") ||
            mentions(message, "Problem"))
            if (!mentions(message, "Cannot parse input")) words += (words.empty() ? "" : "; ") + message;
        if (!mentions(message, "----") && !mentions(message, "====")) last = message;
    }
    return words.empty() ? last : words;
}

}  // namespace haarfield
