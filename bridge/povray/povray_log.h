#pragma once
/// Messages in POV-Ray's log.

#include <string>
#include <vector>

namespace haarfield {

/// Returns POV-Ray's messages, each on one line. POV-Ray breaks lines after 79 columns, before a space if
/// there is one, so that the pieces are joined without a separator.
std::vector<std::string> povray_messages(const std::string& log);

/// Tests whether a message contains a text.
bool mentions(const std::string& message, const char* text);

/// Returns the messages that explain a failure, separated by `; `; the last message if none does.
std::string povray_failure(const std::string& log);

}  // namespace haarfield
