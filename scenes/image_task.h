#pragma once
/// The data that a reader process returns for an image.

#include "fields/file/reader_process.h"
#include "scenes/image.h"

#include <atomic>
#include <string_view>

namespace haarfield {

/// The name of the task. Another number whenever ImageHead or the data behind it change.
inline constexpr std::string_view image_task = "image 1";

/// The head of an answer. The pixels and the coverage follow.
struct ImageHead {
    std::int32_t width, height;
    float relative_error;  ///< Less than 0: none.
};

/// The largest factor between a file and its decoded pixels: a file that is compressed better is a trap.
inline constexpr double most_decoded = 2000;

/// Returns the error of a file that is not an image in a known format.
Error not_an_image(const std::string& where);

/// Decodes an image file's bytes in this process.
using ImageDecoder = Result<Image> (*)(std::string_view bytes, const std::string& where);

/// The decoder of this process; null unless it called read_images_in_this_process().
std::atomic<ImageDecoder>& image_decoder();

}  // namespace haarfield
