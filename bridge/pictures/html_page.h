#pragma once
/// What the pages that we write have in common: looks, pictures in the text, commands.

#include "scenes/image.h"

namespace haarfield {

/// A text as HTML shows it.
std::string escaped(const std::string& text);

/// A picture as an `img` with the PNG in it.
///
/// name    what is shown in its place, and named in errors.
/// kind    its class.
/// errors  those of png_bytes.
Result<std::string> embedded_image(const Image& image, const std::string& name, const char* kind);

/// The beginning of a page, up to its `main`: title and style, nothing from elsewhere, for light and dark
/// mode.
std::string html_head(const std::string& title);

/// The command lines that made what a page shows, in order; nothing if there are none.
std::string commands_section(const std::vector<std::string>& commands);

}  // namespace haarfield
