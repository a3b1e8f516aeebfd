#pragma once
/// Which images are read, and how they are known: by their bytes, whatever their file is called.

#include <string_view>

namespace haarfield {

/// For messages and help.
inline constexpr std::string_view image_formats =
    "OpenEXR, Radiance HDR, PNG, JPEG, TIFF, WebP, BMP or Targa";

/// OpenImageIO's name of the plug-in that reads these bytes, by what they begin with; of Targa, which has no
/// beginning of its own, by a head that makes sense. Null if they are none of image_formats.
const char* image_plugin(std::string_view bytes);

}  // namespace haarfield
