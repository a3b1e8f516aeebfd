#include "scenes/image_encoding.h"

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <png.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <csetjmp>
#include <cstdint>
#include <vector>

namespace haarfield {
namespace {

/// The state of an encoder, for libpng's callbacks.
struct PngOutput {
    std::string bytes;
    std::string failure;
};

[[noreturn]] void stop_encoding(png_structp png, png_const_charp words) {
    static_cast<PngOutput*>(png_get_error_ptr(png))->failure = words;
    png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

void add_bytes(png_structp png, png_bytep bytes, png_size_t count) {
    static_cast<PngOutput*>(png_get_io_ptr(png))->bytes.append(reinterpret_cast<const char*>(bytes), count);
}

/// Encodes rows. Returns false after an error. Has no local objects with destructors, because libpng reports
/// errors by longjmp.
bool write_rows(png_structp png, png_infop info, const png_byte* rows, std::size_t row_bytes, int width,
                int height, int bits, int channels) {
    if (setjmp(png_jmpbuf(png)) != 0) return false;
    png_set_IHDR(png, info, png_uint_32(width), png_uint_32(height), bits,
                 channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (bits == 8)
        png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_ABSOLUTE);
    else
        png_set_gAMA(png, info, 1.0);
    png_write_info(png, info);
    if (bits == 16 && std::endian::native == std::endian::little) png_set_swap(png);
    for (int row = 0; row < height; ++row) png_write_row(png, rows + std::size_t(row) * row_bytes);
    png_write_end(png, info);
    return true;
}

Result<std::string> encoded_rows(std::span<const std::byte> texels, int width, int height, int bits) {
    const std::size_t row_bytes = texels.size() / std::size_t(height);
    PngOutput output;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &output, stop_encoding, ignore_warning);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    bool is_written = false;
    if (info) {
        png_set_write_fn(png, &output, add_bytes, nullptr);
        is_written = write_rows(png, info, reinterpret_cast<const png_byte*>(texels.data()), row_bytes, width,
                                height, bits, int(row_bytes / (std::size_t(width) * std::size_t(bits) / 8)));
    }
    png_destroy_write_struct(&png, &info);
    if (!is_written) return Error{"", output.failure.empty() ? "not enough memory" : output.failure};
    return std::move(output.bytes);
}

/// A file in memory.
class MemoryStream : public Imf::OStream {
public:
    MemoryStream() : OStream("picture") {}
    void write(const char bytes[], int count) override {
        if (place_ + std::size_t(count) > bytes_.size()) bytes_.resize(place_ + std::size_t(count));
        bytes_.replace(place_, std::size_t(count), bytes, std::size_t(count));
        place_ += std::size_t(count);
    }
    std::uint64_t tellp() override { return place_; }
    void seekp(std::uint64_t place) override { place_ = place; }

    std::string bytes_;

private:
    std::size_t place_ = 0;
};

}  // namespace

Result<std::string> encoded_png(std::span<const std::uint8_t> texels, int width, int height) {
    return encoded_rows(std::as_bytes(texels), width, height, 8);
}

Result<std::string> encoded_png(std::span<const std::uint16_t> texels, int width, int height) {
    return encoded_rows(std::as_bytes(texels), width, height, 16);
}

Result<std::string> encoded_exr(const std::function<void(int row, std::span<float> values)>& fill, int width,
                                int height, std::size_t channels, std::optional<float> relative_error,
                                ExrCompression compression) {
    assert(width > 0 && height > 0 && (channels == 3 || channels == 4));
    constexpr int rows_at_once = 32;  // one compressed block of PIZ, two of ZIP
    constexpr const char* names[] = {"R", "G", "B", "A"};
    Imf::Header header(width, height);
    header.compression() = compression == ExrCompression::piz ? Imf::PIZ_COMPRESSION : Imf::ZIP_COMPRESSION;
    if (relative_error) header.insert(error_attribute, Imf::FloatAttribute(*relative_error));
    for (std::size_t c = 0; c < channels; ++c) header.channels().insert(names[c], Imf::Channel(Imf::HALF));
    const std::size_t row_values = std::size_t(width) * channels, step = channels * sizeof(Imath::half);
    std::vector<float> values(row_values);
    std::vector<Imath::half> halves(row_values * rows_at_once);
    MemoryStream stream;
    // Growing by doubling would use three times the memory. Reserved pages are used only as they are filled.
    stream.bytes_.reserve(row_values * std::size_t(height) * sizeof(Imath::half));
    try {
        Imf::OutputFile file(stream, header);
        for (int first = 0; first < height; first += rows_at_once) {
            const int count = std::min(rows_at_once, height - first);
            for (int row = 0; row < count; ++row) {
                fill(first + row, values);
                std::copy(values.begin(), values.end(),
                          halves.begin() + std::ptrdiff_t(row) * std::ptrdiff_t(row_values));
            }
            Imf::FrameBuffer buffer;
            for (std::size_t c = 0; c < channels; ++c) {
                // Addresses are relative to row 0 of the picture.
                const auto start = reinterpret_cast<std::uintptr_t>(halves.data() + c) -
                                   std::uintptr_t(first) * step * std::uintptr_t(width);
                buffer.insert(names[c], Imf::Slice(Imf::HALF, reinterpret_cast<char*>(start), step,
                                                   step * std::size_t(width)));
            }
            file.setFrameBuffer(buffer);
            file.writePixels(count);
        }
    } catch (const std::exception& error) {
        return Error{"", error.what()};
    }
    return std::move(stream.bytes_);
}

}  // namespace haarfield
