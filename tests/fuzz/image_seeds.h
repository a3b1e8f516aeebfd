#pragma once
/// Small images that are whole, to be damaged.

#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// Files of a format: jpeg, webp, tiff, hdr, bmp, targa or exr; of different compressions.
std::vector<std::string> example_image_files(std::string_view format);

}  // namespace haarfield
