#include "scenes/image_reader.h"

#include "scenes/image_encoding.h"
#include "scenes/image_format.h"
#include "scenes/image_task.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

namespace haarfield {
namespace {

constexpr std::uint64_t largest_image = std::uint64_t{1} << 28;  // pixels
constexpr int most_channels = 64;
constexpr int rows_at_once = 64;

std::string open_image_error(std::string words) {
    while (!words.empty() && (words.back() == '\n' || words.back() == ' ')) words.pop_back();
    constexpr std::string_view no_memory = "std::bad_alloc";
    if (const std::size_t at = words.find(no_memory); at != std::string::npos)
        words.replace(at, no_memory.size(), "not enough memory");
    return words.empty() ? "unknown error" : words;
}

/// True for integer formats, which are sRGB-encoded. Floating point is linear.
bool is_encoded(const OIIO::ImageSpec& spec) {
    return spec.format == OIIO::TypeDesc::UINT8 || spec.format == OIIO::TypeDesc::UINT16;
}

/// Returns OpenImageIO's options for read_image.
OIIO::ImageSpec reading_options() {
    OIIO::ImageSpec wanted;
    wanted.attribute("oiio:UnassociatedAlpha", 1);  // otherwise OpenImageIO multiplies by alpha
    return wanted;
}

constexpr std::uint64_t always_decoded = std::uint64_t{1} << 24;  // pixels, for any size of the file

/// Decodes an image.
///
/// file_bytes  size of the file.
Result<Image> image_from(OIIO::ImageInput& input, std::size_t file_bytes, const std::string& where) {
    const OIIO::ImageSpec spec = input.spec();
    const bool has_alpha = spec.alpha_channel >= 0;
    const int colours = spec.nchannels - (has_alpha ? 1 : 0);
    if (colours != 1 && colours < 3)
        return Error{where, fmt::format("{} colour channels; expected 1 or 3", colours)};
    if (spec.deep)
        return Error{where, "has several samples in each pixel (deep data); expected a flat image"};
    if (spec.depth > 1) return Error{where, "a volume; expected a picture"};
    if (spec.width < 1 || spec.height < 1 || spec.full_width < 1 || spec.full_height < 1 ||
        spec.image_pixels() > largest_image ||
        static_cast<std::uint64_t>(spec.full_width) * static_cast<std::uint64_t>(spec.full_height) >
            largest_image)
        return Error{where,
                     fmt::format("{} x {} pixels; expected 1 to 2^28", spec.full_width, spec.full_height)};

    if (spec.nchannels > most_channels)
        return Error{where, fmt::format("{} channels; expected up to {}", spec.nchannels, most_channels)};
    const double decoded = double(spec.image_bytes());
    if (std::max<std::uint64_t>(spec.image_pixels(), std::uint64_t(spec.full_width) * spec.full_height) >
            always_decoded &&
        decoded > most_decoded * double(file_bytes))
        return Error{where, fmt::format("{} x {} pixels in {} bytes; expected a file that holds them",
                                        spec.width, spec.height, file_bytes)};

    // The data window of an EXR may be smaller or larger than the picture. Missing pixels are background.
    Image image{spec.full_width, spec.full_height, {}, {}};
    if (const float error = spec.get_float_attribute(error_attribute, -1); error >= 0)
        image.relative_error = error;
    const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
    image.pixels.resize(pixels, Rgb(0, 0, 0));
    if (has_alpha) image.coverage.resize(pixels, 0.0f);
    const bool encoded = is_encoded(spec);
    std::array<int, 3> channel{0, 0, 0};  // index of each colour's channel: those of the file, without alpha
    for (int c = 0, next = 0; c < spec.nchannels && next < (colours == 1 ? 1 : 3); ++c)
        if (c != spec.alpha_channel) channel[next++] = c;
    if (colours == 1) channel[1] = channel[2] = channel[0];
    // Scanlines are decoded in pieces: the floats of all channels may need more memory than the image.
    const int piece = spec.tile_width > 0 ? spec.height : std::min(spec.height, rows_at_once);
    std::vector<float> values(static_cast<std::size_t>(piece) * spec.width * spec.nchannels);
    for (int row = 0; row < spec.height; ++row) {
        if (row % piece == 0) {
            const int first = spec.y + row, end = std::min(first + piece, spec.y + spec.height);
            const bool is_read =
                spec.tile_width > 0
                    ? input.read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data())
                    : input.read_scanlines(0, 0, first, end, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT,
                                           values.data());
            if (!is_read || input.has_error()) return Error{where, open_image_error(input.geterror())};
        }
        const int y = row + spec.y - spec.full_y;
        if (y < 0 || y >= image.height) continue;
        for (int column = 0; column < spec.width; ++column) {
            const int x = column + spec.x - spec.full_x;
            if (x < 0 || x >= image.width) continue;
            const float* value =
                &values[(static_cast<std::size_t>(row % piece) * spec.width + column) * spec.nchannels];
            const std::size_t pixel = static_cast<std::size_t>(y) * image.width + x;
            for (int c = 0; c < 3; ++c)
                image.pixels[pixel][c] = encoded ? srgb_decoded(value[channel[c]]) : value[channel[c]];
            if (has_alpha) {
                const float alpha = value[spec.alpha_channel];
                image.coverage[pixel] = alpha > 0 ? std::min(alpha, 1.0f) : 0.0f;  // NaN is background
            }
        }
    }
    return image;
}

/// The bytes of a file in memory, with checked offsets. A BMP file may declare a negative offset of its
/// pixels, at which OpenImageIO's reader would read before the first byte.
class FileBytes : public OIIO::Filesystem::IOMemReader {
public:
    using IOMemReader::IOMemReader;
    std::size_t pread(void* to, std::size_t count, std::int64_t offset) override {
        return offset < 0 ? 0 : IOMemReader::pread(to, count, offset);
    }
};

Result<Image> decoded_image(std::string_view bytes, const std::string& where) {
    const char* const plugin = image_plugin(bytes);
    if (!plugin) return not_an_image(where);
    FileBytes memory(bytes.data(), bytes.size());
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(plugin);
    if (!input) return Error{where, open_image_error(OIIO::geterror())};
    if (!input->set_ioproxy(&memory)) return Error{where, open_image_error(input->geterror())};
    OIIO::ImageSpec spec;
    if (!input->open(where, spec, reading_options())) {
        const std::string words = input->geterror();
        return Error{where, open_image_error(words.empty() ? OIIO::geterror() : words)};
    }
    return image_from(*input, bytes.size(), where);
}

Result<Done> read_task(std::string_view bytes, std::string_view, ByteSink& answer) {
    HF_TRY(const Image image, decoded_image(bytes, ""));
    answer.value(ImageHead{image.width, image.height, image.relative_error.value_or(-1)});
    answer.values(image.pixels);
    answer.values(image.coverage);
    return Done{};
}

}  // namespace

ReaderTask image_reader_task() {
    return {image_task, read_task};
}

void read_images_in_this_process() {
    image_decoder() = decoded_image;
}

}  // namespace haarfield
