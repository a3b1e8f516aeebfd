#include "scenes/image.h"

#include "fields/base/exception_message.h"
#include "fields/base/names.h"
#include "fields/file/input_file.h"
#include "fields/file/mapped_file.h"
#include "fields/file/write_file.h"
#include "scenes/image_encoding.h"
#include "scenes/image_format.h"
#include "scenes/image_task.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace haarfield {
namespace {

constexpr float largest_half = 65000.0f;  // below 65504, the end of half floats

Result<Done> check_finite(std::span<const Rgb> pixels, std::span<const float> coverage, int width,
                          const std::string& where) {
    for (std::size_t i = 0; i < pixels.size(); ++i)
        if (!is_finite(pixels[i]) || (!coverage.empty() && !std::isfinite(coverage[i])))
            return Error{where, fmt::format("pixel ({}, {}) is not finite", i % std::size_t(width),
                                            i / std::size_t(width))};
    return Done{};
}

/// Adds the place to the error of an encoder.
Result<std::string> named(Result<std::string> bytes, const std::string& where) {
    if (!bytes) return Error{where, bytes.error().what};
    return bytes;
}

Result<std::string> exr_bytes(std::span<const Rgb> pixels, std::span<const float> coverage, int width,
                              int height, std::optional<float> relative_error, ExrCompression compression,
                              const std::string& where) {
    const std::size_t channels = coverage.empty() ? 3 : 4, row_pixels = std::size_t(width);
    const auto fill = [&](int row, std::span<float> values) {
        auto value = values.begin();
        for (std::size_t i = std::size_t(row) * row_pixels; i < (std::size_t(row) + 1) * row_pixels; ++i) {
            for (int c = 0; c < 3; ++c) *value++ = std::clamp(pixels[i][c], -largest_half, largest_half);
            if (channels == 4) *value++ = std::clamp(coverage[i], 0.0f, 1.0f);
        }
    };
    return named(encoded_exr(fill, width, height, channels, relative_error, compression), where);
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
    return named(encoded_png(values, image.width, image.height), where);
}

Result<Done> check_shape(const Image& image, const std::string& where) {
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    assert(image.pixels.size() == pixels && (image.coverage.empty() || image.coverage.size() == pixels));
    if (pixels == 0) return Error{where, "the image is empty"};
    return check_finite(image.pixels, image.coverage, image.width, where);
}

constexpr double memory_per_decoded = 9;  // bytes per decoded byte: floats, and the Image

/// Reads pixels, and releases pages of the answer that are copied: both together need little more memory than
/// one of them.
std::vector<Rgb> moved_pixels(ByteSource& source, std::string_view answer, std::size_t first_byte) {
    constexpr std::size_t most_at_once = 1 << 16;  // pixels
    const std::size_t count = source.count(sizeof(Rgb));
    std::vector<Rgb> pixels;
    pixels.reserve(count);
    for (std::size_t released = 0; pixels.size() < count;) {
        const std::size_t end = std::min(pixels.size() + most_at_once, count);
        while (pixels.size() < end) pixels.push_back(source.value<Rgb>());
        const std::size_t end_byte = first_byte + end * sizeof(Rgb);
        release_pages(answer.substr(released, end_byte - released));
        released = end_byte;
    }
    return pixels;
}

/// Converts the answer of a reader process, which is untrusted.
Result<Image> image_from_answer(std::string_view answer, const std::string& where) {
    ByteSource source(answer);
    const auto head = source.value<ImageHead>();
    Image image{head.width, head.height, {}, {}};
    image.pixels = moved_pixels(source, answer, sizeof(ImageHead) + sizeof(std::uint64_t));
    image.coverage = source.values<float>();
    if (head.relative_error >= 0) image.relative_error = head.relative_error;
    const bool has_size = head.width >= 1 && head.height >= 1;
    const std::uint64_t pixels = has_size ? std::uint64_t(head.width) * std::uint64_t(head.height) : 0;
    if (!source.is_at_end() || pixels == 0 || image.pixels.size() != pixels ||
        (!image.coverage.empty() && image.coverage.size() != pixels) ||
        !std::ranges::all_of(image.coverage, [](float share) { return share >= 0 && share <= 1; }))
        return Error{where, "the reader process returned no valid image: the file is damaged"};
    return image;
}

/// Decodes in a reader process if there is one, else in this process.
///
/// source  the bytes, or the descriptor of a file that holds them.
template <class Source>
Result<Image> guarded_image(std::string_view bytes, const Source& source, const std::string& where) {
    const Result<bool> apart = reads_apart();
    if (!apart) return Error{where, apart.error().what};
    if (!*apart) {
        const ImageDecoder decode = image_decoder();
        if (!decode) return Error{where, "no reader process reads images: haarfield-reader was not found"};
        try {
            return decode(bytes, where);
        } catch (const std::exception& error) {  // out of memory; damaged files, by libraries
            return Error{where, exception_message(error)};
        }
    }
    HF_TRY(const MappedFile answer,
           read_apart(image_task, source, "", reader_limits(bytes.size(), most_decoded * memory_per_decoded),
                      where));
    return image_from_answer(answer.bytes, where);
}

}  // namespace

Error not_an_image(const std::string& where) {
    return {where, fmt::format("not an image that can be read; expected {}", image_formats)};
}

std::atomic<ImageDecoder>& image_decoder() {
    static std::atomic<ImageDecoder> decoder = nullptr;
    return decoder;
}

Result<Image> read_image(const std::filesystem::path& file) {
    const std::string where = file.string();
    HF_TRY(const InputFile opened, InputFile::open(file));
    HF_TRY(const MappedFile mapped, mapped_file(opened.descriptor(), where, MappedPages::as_read));
    if (!image_plugin(mapped.bytes)) return not_an_image(where);
    return guarded_image(mapped.bytes, opened.descriptor(), where);
}

Result<Image> read_image_bytes(std::string_view bytes, const std::string& where) {
    return guarded_image(bytes, bytes, where);
}

Result<Done> write_image(const Image& image, const std::filesystem::path& file) {
    const std::string where = file.string();
    HF_TRY_DONE(check_shape(image, where));
    const std::string ending = lower_ending(file);
    if (ending != ".exr" && ending != ".png")
        return Error{where, "found an unknown extension; expected .exr or .png"};
    HF_TRY(const std::string bytes, ending == ".exr"
                                        ? exr_bytes(image.pixels, image.coverage, image.width, image.height,
                                                    image.relative_error, ExrCompression::zip, where)
                                        : png_file_bytes(image, /*with_alpha=*/false, where));
    return write_file(file, bytes);
}

Result<Done> write_environment_image(const LatLongImage& image, const std::filesystem::path& file) {
    const std::string where = file.string();
    if (image.pixels.empty()) return Error{where, "the image is empty"};
    HF_TRY_DONE(check_finite(image.pixels, {}, image.width, where));
    HF_TRY(const std::string bytes,
           exr_bytes(image.pixels, {}, image.width, image.height, std::nullopt, ExrCompression::piz, where));
    return write_file(file, bytes);
}

Result<std::string> png_bytes(const Image& image) {
    HF_TRY_DONE(check_shape(image, "picture"));
    return png_file_bytes(image, !image.coverage.empty(), "picture");
}

Result<std::string> png_bytes(std::span<const std::array<std::uint8_t, 4>> texels, int width, int height,
                              bool with_alpha) {
    assert(texels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    std::vector<std::uint8_t> values;
    values.reserve(4 * texels.size());
    for (const auto& texel : texels)
        values.insert(values.end(), texel.begin(), texel.end() - (with_alpha ? 0 : 1));
    return named(encoded_png(values, width, height), "PNG");
}

Result<std::string> png_bytes(std::span<const std::array<std::uint16_t, 3>> texels, int width, int height) {
    assert(texels.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const std::span<const std::uint16_t> numbers(texels.empty() ? nullptr : texels[0].data(),
                                                 3 * texels.size());
    return named(encoded_png(numbers, width, height), "PNG");
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
    HF_TRY(Image image, read_image(file));
    if (image.width != 2 * image.height)
        return Error{file.string(),
                     fmt::format("found {} x {} pixels; expected a lat-long image, twice as wide as high",
                                 image.width, image.height)};
    return LatLongImage{image.width, image.height, std::move(image.pixels)};
}

}  // namespace haarfield
