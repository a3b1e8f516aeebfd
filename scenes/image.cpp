#include "scenes/image.h"

#include "fields/base/exception_message.h"
#include "fields/base/names.h"
#include "fields/file/mapped_file.h"
#include "fields/file/write_file.h"
#include "scenes/image_format.h"

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
constexpr float largest_half = 65000.0f;  // below 65504, the end of half floats
constexpr const char* error_attribute = "haarfield:relative_error";

std::string open_image_error(std::string words) {
    while (!words.empty() && (words.back() == '\n' || words.back() == ' ')) words.pop_back();
    constexpr std::string_view no_memory = "std::bad_alloc";
    if (const std::size_t at = words.find(no_memory); at != std::string::npos)
        words.replace(at, no_memory.size(), "not enough memory");
    return words.empty() ? "unknown error" : words;
}

/// Integer formats hold sRGB; only these have a code value of 1.
bool is_encoded(const OIIO::ImageSpec& spec) {
    return spec.format == OIIO::TypeDesc::UINT8 || spec.format == OIIO::TypeDesc::UINT16;
}

Result<Done> check_finite(const Image& image, const std::string& where) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        if (!is_finite(image.pixels[i]) || (!image.coverage.empty() && !std::isfinite(image.coverage[i])))
            return Error{where,
                         fmt::format("pixel ({}, {}) is not finite", i % image.width, i / image.width)};
    return Done{};
}

Result<std::string> encoded_file(const std::string& format, OIIO::ImageSpec spec, OIIO::TypeDesc type,
                                 const void* data, const std::string& where) {
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(format);
    if (!output) return Error{where, open_image_error(OIIO::geterror())};
    if (!output->set_ioproxy(&memory)) return Error{where, open_image_error(output->geterror())};
    if (!output->open(where, spec) || !output->write_image(type, data) || !output->close())
        return Error{where, open_image_error(output->geterror())};
    return std::string(bytes.begin(), bytes.end());
}

Result<std::string> exr_bytes(const Image& image, const std::string& where) {
    const int channels = image.coverage.empty() ? 3 : 4;
    std::vector<float> values;
    values.reserve(image.pixels.size() * channels);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        for (int c = 0; c < 3; ++c)
            values.push_back(std::clamp(image.pixels[i][c], -largest_half, largest_half));
        if (channels == 4) values.push_back(std::clamp(image.coverage[i], 0.0f, 1.0f));
    }
    OIIO::ImageSpec spec(image.width, image.height, channels, OIIO::TypeDesc::HALF);
    spec.attribute("compression", "zip");
    // Otherwise it would be the time of writing, and equal pictures were unequal files.
    spec.attribute("DateTime", "2000:01:01 00:00:00");
    if (image.relative_error) spec.attribute(error_attribute, *image.relative_error);
    return encoded_file("openexr", spec, OIIO::TypeDesc::FLOAT, values.data(), where);
}

Result<std::string> png_file_bytes(const std::vector<std::uint8_t>& values, int width, int height,
                                   int channels, const std::string& where) {
    OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    return encoded_file("png", spec, OIIO::TypeDesc::UINT8, values.data(), where);
}

Result<std::string> png_file_bytes(const Image& image, bool with_alpha, const std::string& where) {
    const int channels = with_alpha ? 4 : 3;
    std::vector<std::uint8_t> values;
    values.reserve(image.pixels.size() * channels);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const float alpha = with_alpha ? std::clamp(image.coverage[i], 0.0f, 1.0f) : 1.0f;
        for (int c = 0; c < 3; ++c)
            values.push_back(unit_byte(srgb_encoded(alpha > 0 ? image.pixels[i][c] / alpha : 0.0f)));
        if (with_alpha) values.push_back(unit_byte(alpha));
    }
    return png_file_bytes(values, image.width, image.height, channels, where);
}

Result<Done> check_shape(const Image& image, const std::string& where) {
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    assert(image.pixels.size() == pixels && (image.coverage.empty() || image.coverage.size() == pixels));
    if (pixels == 0) return Error{where, "the image is empty"};
    return check_finite(image, where);
}

/// As read_image asks for them.
OIIO::ImageSpec reading_options() {
    OIIO::ImageSpec wanted;
    wanted.attribute("oiio:UnassociatedAlpha", 1);  // or OpenImageIO would multiply by alpha
    return wanted;
}

/// How much more than a file has its pixels may be: what is compressed better than this is a trap.
constexpr double most_decoded = 2000;
constexpr std::uint64_t always_decoded = std::uint64_t{1} << 24;  // pixels that need no reason
constexpr double memory_per_decoded = 9;                          // of bytes: as floats, and as an Image

/// file_bytes  how many the file has.
Result<Image> image_from(OIIO::ImageInput& input, std::size_t file_bytes, const std::string& where) {
    const OIIO::ImageSpec spec = input.spec();
    const bool has_alpha = spec.alpha_channel >= 0;
    const int colours = spec.nchannels - (has_alpha ? 1 : 0);
    if (colours != 1 && colours < 3)
        return Error{where, fmt::format("{} colour channels; wanted 1 or 3", colours)};
    if (spec.deep)
        return Error{where, "has several samples in each pixel (deep data); expected a flat image"};
    if (spec.depth > 1) return Error{where, "a volume; wanted a picture"};
    if (spec.width < 1 || spec.height < 1 || spec.full_width < 1 || spec.full_height < 1 ||
        spec.image_pixels() > largest_image ||
        static_cast<std::uint64_t>(spec.full_width) * static_cast<std::uint64_t>(spec.full_height) >
            largest_image)
        return Error{where,
                     fmt::format("{} x {} pixels; wanted 1 to 2^28", spec.full_width, spec.full_height)};

    if (spec.nchannels > most_channels)
        return Error{where, fmt::format("{} channels; wanted up to {}", spec.nchannels, most_channels)};
    const double decoded = double(spec.image_bytes());
    if (std::max<std::uint64_t>(spec.image_pixels(), std::uint64_t(spec.full_width) * spec.full_height) >
            always_decoded &&
        decoded > most_decoded * double(file_bytes))
        return Error{where, fmt::format("{} x {} pixels in {} bytes; wanted a file that holds them",
                                        spec.width, spec.height, file_bytes)};

    std::vector<float> values(static_cast<std::size_t>(spec.image_pixels()) * spec.nchannels);
    if (!input.read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data()))
        return Error{where, open_image_error(input.geterror())};
    if (input.has_error()) return Error{where, open_image_error(input.geterror())};

    // An EXR's data window may be smaller or larger than the picture: what it lacks is black background.
    Image image{spec.full_width, spec.full_height, {}, {}};
    if (const float error = spec.get_float_attribute(error_attribute, -1); error >= 0)
        image.relative_error = error;
    const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
    image.pixels.resize(pixels, Rgb(0, 0, 0));
    if (has_alpha) image.coverage.resize(pixels, 0.0f);
    const bool encoded = is_encoded(spec);
    std::array<int, 3> channel{0, 0, 0};  // of each colour: all but alpha, in the file's order
    for (int c = 0, next = 0; c < spec.nchannels && next < (colours == 1 ? 1 : 3); ++c)
        if (c != spec.alpha_channel) channel[next++] = c;
    if (colours == 1) channel[1] = channel[2] = channel[0];
    for (int row = 0; row < spec.height; ++row) {
        const int y = row + spec.y - spec.full_y;
        if (y < 0 || y >= image.height) continue;
        for (int column = 0; column < spec.width; ++column) {
            const int x = column + spec.x - spec.full_x;
            if (x < 0 || x >= image.width) continue;
            const float* value =
                &values[(static_cast<std::size_t>(row) * spec.width + column) * spec.nchannels];
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

constexpr std::string_view task_name = "image 1";  // another number whenever ImageHead or its data change

/// A file's bytes, and nothing beside them: OpenImageIO's own reader of memory goes to where a BMP file says
/// that its pixels are, before the first byte if that is negative.
class FileBytes : public OIIO::Filesystem::IOMemReader {
public:
    using IOMemReader::IOMemReader;
    std::size_t pread(void* to, std::size_t count, std::int64_t offset) override {
        return offset < 0 ? 0 : IOMemReader::pread(to, count, offset);
    }
};

Error not_an_image(const std::string& where) {
    return {where, fmt::format("not an image that can be read; wanted {}", image_formats)};
}

/// In this process.
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

/// Before its pixels and its coverage.
struct ImageHead {
    std::int32_t width, height;
    float relative_error;  ///< Less than 0: none.
};

Result<Done> read_task(std::string_view bytes, std::string_view, ByteSink& answer) {
    const Result<Image> image = decoded_image(bytes, "");
    if (!image) return image.error();
    answer.value(ImageHead{image->width, image->height, image->relative_error.value_or(-1)});
    answer.values(image->pixels);
    answer.values(image->coverage);
    return Done{};
}

/// What a reader process has made of it, of which nothing is believed.
Result<Image> image_from_answer(std::string_view answer, const std::string& where) {
    ByteSource source(answer);
    const auto head = source.value<ImageHead>();
    Image image{head.width, head.height, source.values<Rgb>(), source.values<float>()};
    if (head.relative_error >= 0) image.relative_error = head.relative_error;
    const bool has_size = head.width >= 1 && head.height >= 1;
    const std::uint64_t pixels = has_size ? std::uint64_t(head.width) * std::uint64_t(head.height) : 0;
    if (!source.is_at_end() || pixels == 0 || image.pixels.size() != pixels ||
        (!image.coverage.empty() && image.coverage.size() != pixels) ||
        !std::ranges::all_of(image.coverage, [](float share) { return share >= 0 && share <= 1; }))
        return Error{where, "what its reader made of it is not an image: the file is damaged"};
    return image;
}

/// In a reader process, or in this one.
Result<Image> guarded_image(std::string_view bytes, const std::string& where) {
    const Result<bool> apart = reads_apart();
    if (!apart) return Error{where, apart.error().what};
    if (!*apart) {
        try {
            return decoded_image(bytes, where);
        } catch (const std::exception& error) {  // memory; libraries', on some damaged files
            return Error{where, exception_message(error)};
        }
    }
    const Result<MappedFile> answer = read_apart(
        task_name, bytes, "", reader_limits(bytes.size(), most_decoded * memory_per_decoded), where);
    if (!answer) return answer.error();
    return image_from_answer(answer->bytes, where);
}

}  // namespace

Result<Image> read_image(const std::filesystem::path& file) {
    const std::string where = file.string();
    const Result<MappedFile> mapped = mapped_file(file, MappedPages::as_read);
    if (!mapped) return mapped.error();
    if (!image_plugin(mapped->bytes)) return not_an_image(where);
    if (const Result<Done> loaded = load_pages(*mapped, where); !loaded) return loaded.error();
    return guarded_image(mapped->bytes, where);
}

Result<Image> read_image_bytes(std::string_view bytes, const std::string& where) {
    return guarded_image(bytes, where);
}

ReaderTask image_reader_task() {
    return {task_name, read_task};
}

Result<Done> write_image(const Image& image, const std::filesystem::path& file) {
    const std::string where = file.string();
    if (Result<Done> good = check_shape(image, where); !good) return good.error();
    const std::string ending = lower_ending(file);
    if (ending != ".exr" && ending != ".png") return Error{where, "the ending is not .exr or .png"};
    const Result<std::string> bytes =
        ending == ".exr" ? exr_bytes(image, where) : png_file_bytes(image, /*with_alpha=*/false, where);
    if (!bytes) return bytes.error();
    return write_file(file, *bytes);
}

Result<std::string> png_bytes(const Image& image) {
    if (Result<Done> good = check_shape(image, "picture"); !good) return good.error();
    return png_file_bytes(image, !image.coverage.empty(), "picture");
}

Result<std::string> png_bytes(std::span<const std::array<std::uint8_t, 4>> texels, int width, int height,
                              bool with_alpha) {
    assert(texels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    std::vector<std::uint8_t> values;
    values.reserve(4 * texels.size());
    for (const auto& texel : texels)
        values.insert(values.end(), texel.begin(), texel.end() - (with_alpha ? 0 : 1));
    return png_file_bytes(values, width, height, with_alpha ? 4 : 3, "PNG");
}

Result<std::string> png_bytes(std::span<const std::array<std::uint16_t, 3>> texels, int width, int height) {
    assert(texels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT16);
    spec.attribute("oiio:ColorSpace", "linear");
    return encoded_file("png", spec, OIIO::TypeDesc::UINT16, texels.data(), "PNG");
}

double clipped_share(const Image& image) {
    std::size_t counted = 0, clipped = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const float coverage = image.coverage.empty() ? 1 : image.coverage[i];
        if (coverage < 0.5f) continue;
        ++counted;
        const Rgb& pixel = image.pixels[i];
        clipped += std::max({pixel.x, pixel.y, pixel.z}) > coverage;
    }
    return counted > 0 ? static_cast<double>(clipped) / static_cast<double>(counted) : 0;
}

Image over(const Image& image, const Image& background) {
    assert(image.width == background.width && image.height == background.height);
    Image result = image;
    result.coverage.clear();
    for (std::size_t i = 0; i < image.coverage.size(); ++i)
        result.pixels[i] += background.pixels[i] * (1.0f - image.coverage[i]);
    return result;
}

Result<LatLongImage> read_environment_image(const std::filesystem::path& file) {
    Result<Image> image = read_image(file);
    if (!image) return image.error();
    if (image->width != 2 * image->height)
        return Error{file.string(), fmt::format("{} x {} pixels; a lat-long image is twice as wide as high",
                                                image->width, image->height)};
    return LatLongImage{image->width, image->height, std::move(image->pixels)};
}

}  // namespace haarfield
