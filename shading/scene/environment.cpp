#include "shading/scene/environment.h"

#include "fields/base/spiral.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

namespace haarfield {

EnvironmentFindings clean_environment(LatLongImage& image) {
    const std::size_t width = std::size_t(image.width), height = std::size_t(image.height);
    std::vector<float> largest_of_row(height, 0.0f);
    std::vector<EnvironmentFindings> found(height);
    const auto for_each_row = [&](const auto& change) {
        tbb::parallel_for(std::size_t(0), height, [&](std::size_t row) {
            change(row, std::span(image.pixels).subspan(row * width, width));
        });
    };
    for_each_row([&](std::size_t row, std::span<Rgb> pixels) {
        float largest = 0;
        for (const Rgb& pixel : pixels)
            for (const float value : {pixel.x, pixel.y, pixel.z})
                if (std::isfinite(value)) largest = std::max(largest, value);
        largest_of_row[row] = largest;
    });
    const float largest = height > 0 ? std::ranges::max(largest_of_row) : 0.0f;
    for_each_row([&](std::size_t row, std::span<Rgb> pixels) {
        for (Rgb& pixel : pixels)
            for (float* value : {&pixel.x, &pixel.y, &pixel.z}) {
                if (*value >= 0 && *value <= largest) continue;
                if (std::isnan(*value)) {
                    *value = 0;
                    ++found[row].non_finite_values;
                } else if (*value < 0) {
                    *value = 0;
                    ++found[row].negative_values;
                } else {
                    *value = largest;
                    ++found[row].non_finite_values;
                }
            }
    });
    EnvironmentFindings findings;
    for (const EnvironmentFindings& of_row : found) {
        findings.negative_values += of_row.negative_values;
        findings.non_finite_values += of_row.non_finite_values;
    }
    return findings;
}

double unevenness(const LatLongImage& image) {
    double sum = 0, squares = 0, all = 0;
    for (int row = 0; row < image.height; ++row) {
        const double solid_angle = lat_long_pixel_solid_angle(row, image.width, image.height);
        for (int column = 0; column < image.width; ++column) {
            const double bright = double(
                luminance(image.pixels[std::size_t(row) * std::size_t(image.width) + std::size_t(column)]));
            sum += bright * solid_angle;
            squares += bright * bright * solid_angle;
            all += solid_angle;
        }
    }
    return sum > 0 ? std::sqrt(squares * all) / sum : 1;
}

LatLongImage turned_environment(LatLongImage image, double rotation, double exposure) {
    assert(image.pixels.size() == std::size_t(image.width) * std::size_t(image.height));
    // Longitude decreases with the column: a rotation towards greater longitudes reads columns further right.
    double shift = std::remainder(rotation / (2 * pi), 1.0) * image.width;
    // Angles are converted from floats: rotations close to whole pixels must not blur the image.
    if (std::abs(shift - std::round(shift)) < 1e-4) shift = std::round(shift);
    const double whole = std::floor(shift);
    const float next_share = float(shift - whole), share = 1 - next_share;
    const float gain = float(std::exp2(exposure));
    if (image.pixels.empty() || (shift == 0 && gain == 1)) return image;

    const std::size_t width = std::size_t(image.width);
    const std::size_t offset = std::size_t((int(whole) % image.width + image.width) % image.width);
    tbb::parallel_for(std::size_t(0), std::size_t(image.height), [&](std::size_t row) {
        Rgb* const pixels = &image.pixels[row * width];
        std::rotate(pixels, pixels + offset, pixels + width);
        const Rgb first = pixels[0];
        for (std::size_t column = 0; column < width; ++column) {
            Rgb value = pixels[column];
            if (next_share > 0)
                value = value * share + (column + 1 < width ? pixels[column + 1] : first) * next_share;
            pixels[column] = value * gain;
        }
    });
    return image;
}

Environment turned_environment(Environment environment, double rotation, double exposure) {
    environment.image = turned_environment(std::move(environment.image), rotation, exposure);
    environment.backdrop = turned_environment(std::move(environment.backdrop), rotation, exposure);
    const double cosine = std::cos(rotation), sine = std::sin(rotation);
    for (SunDisc& sun : environment.suns) {
        const Vec3d d(sun.direction);
        sun.direction = Vec3f(Vec3d(d.x * cosine + d.z * sine, d.y, d.z * cosine - d.x * sine));
        sun.irradiance *= float(std::exp2(exposure));
    }
    return environment;
}

std::vector<Vec3f> disc_directions(const SunDisc& disc, int count, double turn) {
    assert(count >= 1 && disc.angular_radius > 0 && disc.angular_radius <= 0.1f);
    const Vec3d middle = Vec3d(disc.direction).normalized();
    const auto [right, up] = axes_across(middle);
    std::vector<Vec3f> directions;
    for (int i = 0; i < count; ++i) {
        // Rings of equal solid angle: 1 - cosine grows linearly. Half angles avoid cancellation.
        const double half_sine = std::sin(double(disc.angular_radius) / 2) * std::sqrt((i + 0.5) / count);
        const double cosine = 1 - 2 * half_sine * half_sine,
                     sine = 2 * half_sine * std::sqrt(1 - half_sine * half_sine);
        directions.emplace_back(
            middle * cosine +
            (right * std::cos(turn + golden_angle * i) + up * std::sin(turn + golden_angle * i)) * sine);
    }
    return directions;
}

Environment as_backdrop(Environment environment) {
    Environment dark(LatLongImage{4, 2, std::vector<Rgb>(8, Rgb(0.0f))});
    dark.backdrop = image_with_suns(std::move(environment));
    return dark;
}

LatLongImage image_with_suns(Environment environment) {
    if (!environment.backdrop.pixels.empty()) return std::move(environment.backdrop);
    LatLongImage image = std::move(environment.image);
    constexpr int samples = 8192;
    for (const SunDisc& sun : environment.suns)
        for (const Vec3f& direction : disc_directions(sun, samples)) {
            double x, y;
            lat_long_point(Vec3d(direction), x, y);
            const int column = std::min(int(x * image.width), image.width - 1),
                      row = std::min(int(y * image.height), image.height - 1);
            image.pixels[std::size_t(row) * std::size_t(image.width) + std::size_t(column)] +=
                sun.irradiance *
                float(1 / (samples * lat_long_pixel_solid_angle(row, image.width, image.height)));
        }
    return image;
}

double lat_long_pixel_solid_angle(int row, int width, int height) {
    const double top = pi * (0.5 - double(row) / height), bottom = pi * (0.5 - double(row + 1) / height);
    return 2 * pi / width * (std::sin(top) - std::sin(bottom));
}

Rgb radiance_from(const LatLongImage& image, const Vec3d& direction) {
    double x = 0, y = 0;
    lat_long_point(direction.normalized(), x, y);
    const double column = x * image.width - 0.5,
                 row = std::clamp(y * image.height - 0.5, 0.0, image.height - 1.0);
    const int top = std::min(static_cast<int>(row), image.height - 2),
              left = static_cast<int>(std::floor(column));
    const auto right_share = static_cast<float>(column - left), lower_share = static_cast<float>(row - top);
    const auto pixel = [&](int r, int c) -> const Rgb& {
        return image.pixels[std::size_t(r * image.width + (c + image.width) % image.width)];
    };
    const auto along_row = [&](int r) {
        return pixel(r, left) * (1 - right_share) + pixel(r, left + 1) * right_share;
    };
    return along_row(top) * (1 - lower_share) + along_row(top + 1) * lower_share;
}

}  // namespace haarfield
