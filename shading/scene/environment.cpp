#include "shading/scene/environment.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace haarfield {

EnvironmentFindings clean_environment(LatLongImage& image) {
    float largest = 0;
    for (const Rgb& pixel : image.pixels)
        for (const float value : {pixel.x, pixel.y, pixel.z})
            if (std::isfinite(value)) largest = std::max(largest, value);

    EnvironmentFindings findings;
    for (Rgb& pixel : image.pixels)
        for (float* value : {&pixel.x, &pixel.y, &pixel.z}) {
            if (std::isnan(*value)) {
                *value = 0;
                ++findings.non_finite_values;
            } else if (*value < 0) {
                *value = 0;
                ++findings.negative_values;
            } else if (std::isinf(*value)) {
                *value = largest;
                ++findings.non_finite_values;
            }
        }
    return findings;
}

LatLongImage turned_environment(const LatLongImage& image, double rotation, double exposure) {
    assert(image.pixels.size() == std::size_t(image.width) * std::size_t(image.height));
    LatLongImage turned = image;
    if (image.pixels.empty()) return turned;

    // Longitude falls with the column, so that a turn to greater longitudes takes from columns on the right.
    double shift = std::remainder(rotation / (2 * pi), 1.0) * image.width;
    // Angles come in as floats: nearly whole pixels are meant to be whole, and must not blur the image.
    if (std::abs(shift - std::round(shift)) < 1e-4) shift = std::round(shift);
    const double whole = std::floor(shift);
    const float next_share = float(shift - whole), share = 1 - next_share;
    const std::size_t width = std::size_t(image.width);
    const std::size_t offset = std::size_t((int(whole) % image.width + image.width) % image.width);
    const float gain = float(std::exp2(exposure));
    for (std::size_t row = 0; row < std::size_t(image.height); ++row) {
        const Rgb* from = &image.pixels[row * width];
        for (std::size_t column = 0; column < width; ++column) {
            const Rgb& here = from[(column + offset) % width];
            Rgb value = here;
            if (next_share > 0) value = here * share + from[(column + offset + 1) % width] * next_share;
            turned.pixels[row * width + column] = value * gain;
        }
    }
    return turned;
}

double lat_long_pixel_solid_angle(int row, int width, int height) {
    const double top = pi * (0.5 - double(row) / height), bottom = pi * (0.5 - double(row + 1) / height);
    return 2 * pi / width * (std::sin(top) - std::sin(bottom));
}

}  // namespace haarfield
