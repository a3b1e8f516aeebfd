#pragma once
/// The supported image formats. They are detected from content, not from the file name.

#include <string_view>

namespace haarfield {

/// Names of the formats, for messages and help.
inline constexpr std::string_view image_formats =
    "OpenEXR, Radiance HDR, PNG, JPEG, TIFF, WebP, BMP or Targa";

/// Returns the name of the OpenImageIO plug-in that reads these bytes, or null for other formats. Formats are
/// recognized by their first bytes. Targa has no signature and is recognized by a plausible header.
const char* image_plugin(std::string_view bytes);

}  // namespace haarfield
