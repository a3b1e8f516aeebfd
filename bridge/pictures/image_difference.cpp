#include "bridge/pictures/image_difference.h"

#include "bridge/pictures/perceptual_error.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {
namespace {

constexpr double highest_psnr = 99;  // dB; reported for equal images, whose PSNR is infinite

Result<Done> check_finite(const Image& image, const std::string& where) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        if (!is_finite(image.pixels[i]))
            return Error{where,
                         fmt::format("pixel ({}, {}) is not finite", i % image.width, i / image.width)};
    return Done{};
}

std::string size_of(const Image& image) {
    return fmt::format("{} x {}", image.width, image.height);
}

bool covers(const Image& image, std::size_t pixel) {
    return image.coverage.empty() || image.coverage[pixel] >= 0.5f;
}

}  // namespace

Result<ImageDifference> image_difference(const Image& image, const Image& reference,
                                         const ImageDifferenceOptions& options) {
    const std::size_t pixels = image.pixels.size();
    assert(pixels == static_cast<std::size_t>(image.width) * image.height);
    const Image& mask = options.mask;
    if (image.width != reference.width || image.height != reference.height)
        return Error{"image", fmt::format("is {} pixels; expected the size of the reference, {}",
                                          size_of(image), size_of(reference))};
    if (!mask.pixels.empty() && (mask.width != image.width || mask.height != image.height))
        return Error{"mask", fmt::format("is {} pixels; expected the size of the image, {}", size_of(mask),
                                         size_of(image))};
    HF_TRY_DONE(check_finite(image, "image"));
    HF_TRY_DONE(check_finite(reference, "reference"));

    ImageDifference result;
    result.mask.resize(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        const bool counts = covers(image, i) && covers(reference, i) &&
                            (mask.pixels.empty() || luminance(mask.pixels[i]) >= 0.5f);
        result.mask[i] = counts ? 1 : 0;
        result.pixels += result.mask[i];
    }
    if (result.pixels == 0)
        return Error{"mask", "no pixel is compared: no pixel inside the mask is covered by both images"};

    double squares = 0, reference_squares = 0, encoded_squares = 0, sum = 0, reference_sum = 0;
    std::vector<float> luma(pixels), reference_luma(pixels);
    std::vector<Rgb> shown = image.pixels;  // equal to the reference outside the mask
    for (std::size_t i = 0; i < pixels; ++i) {
        if (!result.mask[i]) {
            shown[i] = reference.pixels[i];
            continue;
        }
        Rgb encoded, reference_encoded;
        for (int c = 0; c < 3; ++c) {
            const double a = image.pixels[i][c], b = reference.pixels[i][c];
            squares += (a - b) * (a - b);
            reference_squares += b * b;
            sum += a;
            reference_sum += b;
            encoded[c] = srgb_encoded(image.pixels[i][c]);
            reference_encoded[c] = srgb_encoded(reference.pixels[i][c]);
            const double difference = static_cast<double>(encoded[c]) - reference_encoded[c];
            encoded_squares += difference * difference;
        }
        luma[i] = luminance(encoded);
        reference_luma[i] = luminance(reference_encoded);
    }
    const double values = 3.0 * static_cast<double>(result.pixels);
    result.rmse = std::sqrt(squares / values);
    if (reference_squares > 0)
        result.relative_rmse = std::sqrt(squares / reference_squares);
    else
        result.relative_rmse = squares > 0 ? INFINITY : 0;
    if (reference_sum != 0) result.bias = sum / reference_sum - 1;
    const double mean_square = encoded_squares / values;
    result.psnr_db = mean_square > 0 ? std::min(highest_psnr, -10 * std::log10(mean_square)) : highest_psnr;
    result.ssim = structural_similarity(luma, reference_luma, result.mask, image.width, image.height);

    result.flip_errors =
        flip_errors(shown, reference.pixels, image.width, image.height, options.pixels_per_degree);
    std::vector<float> counted;
    double flip_sum = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
        if (!result.mask[i]) {
            result.flip_errors[i] = 0;
            continue;
        }
        flip_sum += result.flip_errors[i];
        counted.push_back(result.flip_errors[i]);
    }
    result.flip = flip_sum / static_cast<double>(result.pixels);
    const std::size_t rank = (counted.size() - 1) * 99 / 100;
    std::nth_element(counted.begin(), counted.begin() + static_cast<std::ptrdiff_t>(rank), counted.end());
    result.flip_99 = counted[rank];
    return result;
}

/// Follows a path through the Oklab colour space (Ottosson 2020) with linearly increasing lightness: night
/// blue, violet, red, orange, pale yellow. The chroma stays inside the gamut of sRGB.
std::array<std::uint8_t, 3> error_colour(float error) {
    const double t = error > 0 ? std::min(static_cast<double>(error), 1.0) : 0.0;
    const double lightness = 0.14 + 0.84 * t;
    const double hue = (285 + 175 * t) * pi / 180;
    const double chroma = 0.19 * std::sin(pi * std::pow(0.04 + 0.92 * t, 0.85));
    const double a = chroma * std::cos(hue), b = chroma * std::sin(hue);
    const auto cube = [](double v) { return v * v * v; };
    const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
    const double m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
    const double s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
    const double linear[3] = {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                              -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                              -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
    std::array<std::uint8_t, 3> colour;
    for (int c = 0; c < 3; ++c) colour[c] = unit_byte(srgb_encoded(static_cast<float>(linear[c])));
    return colour;
}

Image difference_picture(const ImageDifference& difference, int width, int height, float brightest) {
    assert(brightest > 0);
    assert(difference.mask.size() == static_cast<std::size_t>(width) * height);
    Image picture{width, height, {}, {}};
    for (std::size_t i = 0; i < difference.mask.size(); ++i) {
        const auto colour = error_colour(difference.flip_errors[i] / brightest);
        picture.coverage.push_back(difference.mask[i]);
        picture.pixels.push_back(Rgb(srgb_decoded(static_cast<float>(colour[0]) / 255.0f),
                                     srgb_decoded(static_cast<float>(colour[1]) / 255.0f),
                                     srgb_decoded(static_cast<float>(colour[2]) / 255.0f)) *
                                 picture.coverage[i]);
    }
    return picture;
}

std::vector<std::uint64_t> error_histogram(const ImageDifference& difference, int bins, float upper) {
    assert(bins >= 1 && upper > 0);
    std::vector<std::uint64_t> counts(static_cast<std::size_t>(bins));
    for (std::size_t i = 0; i < difference.mask.size(); ++i) {
        if (!difference.mask[i]) continue;
        const int bin = static_cast<int>(difference.flip_errors[i] / upper * static_cast<float>(bins));
        ++counts[static_cast<std::size_t>(std::min(bin, bins - 1))];
    }
    return counts;
}

}  // namespace haarfield
