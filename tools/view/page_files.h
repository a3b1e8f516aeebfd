#pragma once
/// The page's own files, which are compiled into the program, and three.js, which comes from the system.

#include <string>
#include <string_view>

#include <optional>

namespace haarfield {

/// Returns a file of the page, or of three.js below `three/`; none if the file does not exist.
///
/// path  such as `index.html`; empty: index.html.
std::optional<std::string> page_file(std::string_view path);

/// Returns the content type for a file's name, such as `text/css`.
std::string content_type(std::string_view path);

}  // namespace haarfield
