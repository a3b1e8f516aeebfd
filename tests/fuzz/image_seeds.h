#pragma once
/// Small valid images, as seeds.

#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// Returns files of a format (jpeg, webp, tiff, hdr, bmp, targa or exr) with different compressions.
std::vector<std::string> example_image_files(std::string_view format);

}  // namespace haarfield
