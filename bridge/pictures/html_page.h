#pragma once
/// Common elements of the HTML pages: styles, embedded pictures, commands.

#include "scenes/image.h"

namespace haarfield {

/// Returns a text with HTML's special characters escaped.
std::string escaped(const std::string& text);

/// Returns a picture as an `img` element with an embedded PNG.
///
/// name    the alternative text; also names the picture in errors.
/// kind    the element's class.
/// errors  those of png_bytes.
Result<std::string> embedded_image(const Image& image, const std::string& name, const char* kind);

/// Returns the beginning of a page up to its `main` element: the title and an embedded style for light and
/// dark mode.
std::string html_head(const std::string& title);

/// Returns a section with the command lines that produced the page's contents, in order; empty without
/// commands.
std::string commands_section(const std::vector<std::string>& commands);

}  // namespace haarfield
