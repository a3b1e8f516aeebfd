#include "scenes/texture.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "fields/base/repeated_texels.h"
#include "fields/file/mapped_file.h"
#include "scenes/image.h"

namespace haarfield {
namespace {

/// Linear values by 8 bit sRGB code.
const std::array<float, 256>& linear_values() {
    static const std::array<float, 256> values = [] {
        std::array<float, 256> made;
        for (std::size_t i = 0; i < made.size(); ++i) made[i] = srgb_decoded(static_cast<float>(i) / 255);
        return made;
    }();
    return values;
}

/// The four texels around a point, and their weights.
struct Bilinear {
    std::array<std::size_t, 4> texel;
    std::array<float, 4> weight;

    Bilinear(const Texture& texture, const Vec2f& uv) {
        const double x = double(uv.x) * texture.width - 0.5, y = (1 - double(uv.y)) * texture.height - 0.5;
        const double left = std::floor(x), top = std::floor(y);
        const float right = static_cast<float>(x - left), down = static_cast<float>(y - top);
        for (std::size_t k = 0; k < 4; ++k) {
            const std::int64_t column = static_cast<std::int64_t>(left) + (k % 2),
                               row = static_cast<std::int64_t>(top) + (k / 2);
            texel[k] = repeated_texel(column, row, texture.width, texture.height);
            weight[k] = (k % 2 ? right : 1 - right) * (k / 2 ? down : 1 - down);
        }
    }
};

Result<Image> read(const MeshImage& image) {
    if (image.bytes) return read_image_bytes(*image.bytes, image.name);
    return read_image(image.file);
}

/// Stores the bytes of an image's file if it is a JPEG or PNG and that format is wanted.
Result<Done> take_bytes(const MeshImage& image, bool wants_jpeg, bool wants_png, Texture& texture) {
    const auto take = [&](std::string_view bytes) {
        if (wants_jpeg && bytes.starts_with("\xff\xd8\xff")) texture.jpeg = bytes;
        if (wants_png && bytes.starts_with("\x89PNG\r\n\x1a\n")) texture.png = bytes;
        return Done{};
    };
    if (image.bytes) return take(*image.bytes);
    HF_TRY(const MappedFile mapped, mapped_file(image.file, MappedPages::as_read));
    return take(mapped.bytes);
}

/// Returns the opacity that a map stores at relative coordinates: its alpha, or its luminance.
float opacity_in(const Image& map, double u, double v) {
    const int column = std::min(static_cast<int>(u * map.width), map.width - 1),
              row = std::min(static_cast<int>(v * map.height), map.height - 1);
    const std::size_t pixel = std::size_t(row) * std::size_t(map.width) + std::size_t(column);
    if (!map.coverage.empty()) return map.coverage[pixel];
    // Opacity is a number, not a colour: undoes the sRGB decoding.
    return srgb_encoded(luminance(map.pixels[pixel]));
}

}  // namespace

Rgb Texture::colour_at(const Vec2f& uv) const {
    const Bilinear place(*this, uv);
    const auto& linear = linear_values();
    Rgb sum(0.0f);
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t c = 0; c < 3; ++c)
            sum[int(c)] += place.weight[k] * linear[texels[place.texel[k]][c]];
    return sum;
}

float Texture::opacity_at(const Vec2f& uv) const {
    if (!has_alpha) return 1;
    const Bilinear place(*this, uv);
    float sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += place.weight[k] * float(texels[place.texel[k]][3]);
    return sum / 255;
}

bool Texture::is_cut_out(const std::array<Vec2f, 3>& triangle) const {
    if (!has_alpha) return false;
    // The bounding box of the triangle; any_texel adds the texels of bilinear lookup.
    Vec2f lower = triangle[0], upper = triangle[0];
    for (const Vec2f& uv : triangle)
        for (int axis = 0; axis < 2; ++axis) {
            lower[axis] = std::min(lower[axis], uv[axis]);
            upper[axis] = std::max(upper[axis], uv[axis]);
        }
    return any_texel({double(lower.x), 1 - double(upper.y)}, {double(upper.x), 1 - double(lower.y)}, width,
                     height, [&](std::size_t texel) { return texels[texel][3] != 255; });
}

OpacityMap opacity_map(const Texture& texture) {
    if (!texture.has_alpha) return {};
    OpacityMap map{texture.width, texture.height, {}};
    for (const auto& texel : texture.texels) map.opacity.push_back(texel[3]);
    return map;
}

Result<Texture> read_texture(const TextureSource& source) {
    const bool has_colour = source.image.is_there(), has_map = source.opacity_map.is_there();
    assert(has_colour || has_map);
    const Result<Image> image = read(has_colour ? source.image : source.opacity_map);
    if (!image) return image.error();
    Result<Image> map = Image{};
    if (has_map) map = has_colour ? read(source.opacity_map) : image;
    if (!map) return map.error();

    Texture texture;
    const MeshImage& named = has_colour ? source.image : source.opacity_map;
    texture.name = std::filesystem::path(named.name).stem().string();
    texture.width = image->width;
    texture.height = image->height;
    texture.texels.resize(image->pixels.size());
    Vec3d sum(0.0);
    for (std::size_t i = 0; i < texture.texels.size(); ++i) {
        const double u = (double(i % std::size_t(image->width)) + 0.5) / image->width,
                     v = (double(i / std::size_t(image->width)) + 0.5) / image->height;
        float opacity = 1;
        if (source.alpha != AlphaMode::opaque) {
            if (has_map)
                opacity = opacity_in(*map, u, v);
            else if (!image->coverage.empty())
                opacity = image->coverage[i];
        }
        if (source.alpha == AlphaMode::mask) opacity = opacity >= source.alpha_cutoff ? 1.0f : 0.0f;
        auto& texel = texture.texels[i];
        for (std::size_t c = 0; c < 3; ++c) {
            const float linear = image->pixels[i][int(c)];
            texel[c] = has_colour ? unit_byte(srgb_encoded(linear)) : std::uint8_t(255);
            sum[int(c)] += double(linear_values()[texel[c]]);
        }
        texel[3] = unit_byte(opacity);
        texture.has_alpha |= texel[3] != 255;
    }
    if (std::ranges::all_of(texture.texels, [](const auto& texel) { return texel[3] == 0; })) {
        for (auto& texel : texture.texels) texel[3] = 255;
        texture.has_alpha = false;
    }
    texture.mean = Rgb(Vec3f(sum / double(texture.texels.size())));
    if (has_colour) {
        const bool has_own_alpha = !has_map && source.alpha == AlphaMode::blend;
        HF_TRY_DONE(
            take_bytes(source.image, !texture.has_alpha, !texture.has_alpha || has_own_alpha, texture));
    }
    return texture;
}

Result<Rgb> mean_of_numbers(const MeshImage& image) {
    HF_TRY(const Image map, read(image));
    Vec3d sum(0.0);
    for (const Rgb& pixel : map.pixels)
        for (int c = 0; c < 3; ++c) sum[c] += double(srgb_encoded(pixel[c]));
    return Rgb(Vec3f(sum / double(map.pixels.size())));
}

}  // namespace haarfield
