#pragma once
/// The data that a reader process returns for an image.

#include "fields/file/reader_process.h"
#include "scenes/image.h"

#include <atomic>
#include <string_view>

namespace haarfield {

/// The name of the task. The number increases whenever ImageHead or the data after it change.
inline constexpr std::string_view image_task = "image 1";

/// The head of an answer. The pixels and the coverage follow.
struct ImageHead {
    std::int32_t width, height;
    float relative_error;  ///< Image::relative_error; less than 0: none.
};

/// The largest accepted ratio of decoded bytes to bytes of a file, which prevents decompression bombs.
inline constexpr double most_decoded = 2000;

/// Returns the error of a file that is not an image in a known format.
Error not_an_image(const std::string& where);

/// Decodes an image file's bytes in this process.
using ImageDecoder = Result<Image> (*)(std::string_view bytes, const std::string& where);

/// Returns the decoder of this process; null unless it called read_images_in_this_process().
std::atomic<ImageDecoder>& image_decoder();

}  // namespace haarfield
