#pragma once
/// The page's own files, which are compiled into the program, and three.js, which the system has.

#include <string>
#include <string_view>

#include <optional>

namespace haarfield {

/// A file of the page, or of three.js below `three/`; none if there is no such file.
///
/// path  such as `index.html`, or empty for that.
std::optional<std::string> page_file(std::string_view path);

/// The type of content that a file's name tells, such as `text/css`.
std::string content_type(std::string_view path);

}  // namespace haarfield
