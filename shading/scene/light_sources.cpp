#include "shading/scene/light_sources.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <queue>

namespace haarfield {
namespace {

constexpr int disc_parts = 4096;

/// Calls `visit` with the indices of the eight pixels around a pixel. Beyond a pole lies the same row, half a
/// turn away.
template <class Visit>
void for_each_neighbour(const LatLongImage& image, std::size_t pixel, const Visit& visit) {
    const int width = image.width, row = int(pixel) / width, column = int(pixel) % width;
    for (int down = -1; down <= 1; ++down)
        for (int right = -1; right <= 1; ++right) {
            if (down == 0 && right == 0) continue;
            int r = row + down, c = column + right + width;
            if (r < 0 || r >= image.height) {
                r = row;
                c += width / 2;
            }
            visit(std::size_t(r) * std::size_t(width) + std::size_t(c % width));
        }
}

/// Returns the pixels above a luminance in increasing order.
std::vector<std::size_t> bright_pixels(const LatLongImage& image, double above) {
    const std::size_t width = std::size_t(image.width);
    std::vector<std::vector<std::size_t>> of_row(std::size_t(image.height));
    tbb::parallel_for(std::size_t(0), of_row.size(), [&](std::size_t row) {
        for (std::size_t pixel = row * width; pixel < (row + 1) * width; ++pixel)
            if (double(luminance(image.pixels[pixel])) > above) of_row[row].push_back(pixel);
    });
    std::vector<std::size_t> pixels;
    for (const std::vector<std::size_t>& row : of_row) pixels.insert(pixels.end(), row.begin(), row.end());
    return pixels;
}

/// Returns the 8-connected regions of pixels above a luminance, from the top. Pixels of a region are in the
/// order in which they are reached.
std::vector<std::vector<std::size_t>> bright_regions(const LatLongImage& image, double above) {
    const std::vector<std::size_t> bright = bright_pixels(image, above);
    std::vector<std::vector<std::size_t>> regions;
    std::vector<std::uint8_t> reached(bright.size(), 0);
    const auto reach = [&](std::size_t pixel, std::vector<std::size_t>& region) {
        const auto found = std::ranges::lower_bound(bright, pixel);
        if (found == bright.end() || *found != pixel) return;
        std::uint8_t& is_reached = reached[std::size_t(found - bright.begin())];
        if (!is_reached) region.push_back(pixel);
        is_reached = 1;
    };
    for (const std::size_t pixel : bright) {
        std::vector<std::size_t> region;
        reach(pixel, region);
        for (std::size_t i = 0; i < region.size(); ++i)
            for_each_neighbour(image, region[i], [&](std::size_t other) { reach(other, region); });
        if (!region.empty()) regions.push_back(std::move(region));
    }
    return regions;
}

/// A pixel without the light of its source.
struct DimmedPixel {
    std::size_t pixel;
    Rgb radiance;
};

/// Returns the factor by which the smooth image is smaller than an environment.
int reduction_of(const LatLongImage& image) {
    int factor = 1;
    while (image.width / factor > widest_smooth && image.width % (2 * factor) == 0 &&
           image.height % (2 * factor) == 0)
        factor *= 2;
    return factor;
}

/// Replaces pixels of an image, then averages squares of factor x factor pixels by solid angle.
LatLongImage smooth_image(const LatLongImage& image, std::vector<DimmedPixel> dimmed) {
    std::ranges::sort(dimmed, {}, &DimmedPixel::pixel);
    const int factor = reduction_of(image);
    LatLongImage smooth{image.width / factor, image.height / factor, {}};
    if (factor == 1) {
        smooth.pixels = image.pixels;
        for (const DimmedPixel& one : dimmed) smooth.pixels[one.pixel] = one.radiance;
        return smooth;
    }
    const std::size_t width = std::size_t(image.width), small_width = std::size_t(smooth.width);
    smooth.pixels.resize(small_width * std::size_t(smooth.height), Rgb(0.0f));
    tbb::parallel_for(std::size_t(0), std::size_t(smooth.height), [&](std::size_t row) {
        const std::size_t first_row = row * std::size_t(factor);
        const double whole = lat_long_pixel_solid_angle(int(row), smooth.width, smooth.height);
        std::vector<Rgb> pixels(width);
        Rgb* const sums = &smooth.pixels[row * small_width];
        for (std::size_t r = first_row; r < first_row + std::size_t(factor); ++r) {
            std::copy_n(image.pixels.begin() + std::ptrdiff_t(r * width), width, pixels.begin());
            for (auto one = std::ranges::lower_bound(dimmed, r * width, {}, &DimmedPixel::pixel);
                 one != dimmed.end() && one->pixel < (r + 1) * width; ++one)
                pixels[one->pixel - r * width] = one->radiance;
            const float share = float(lat_long_pixel_solid_angle(int(r), image.width, image.height) / whole);
            for (std::size_t column = 0; column < width; ++column)
                sums[column / std::size_t(factor)] += pixels[column] * share;
        }
    });
    return smooth;
}

/// Returns the mean of the pixels around a region; black if there are none.
Rgb surrounding_level(const LatLongImage& image, const std::vector<std::size_t>& region) {
    std::vector<std::size_t> inside(region), around;
    std::sort(inside.begin(), inside.end());
    for (const std::size_t pixel : region)
        for_each_neighbour(image, pixel, [&](std::size_t other) {
            if (!std::binary_search(inside.begin(), inside.end(), other)) around.push_back(other);
        });
    std::sort(around.begin(), around.end());
    around.erase(std::unique(around.begin(), around.end()), around.end());
    Vec3d sum(0.0);
    for (const std::size_t pixel : around) sum += Vec3d(image.pixels[pixel]);
    return around.empty() ? Rgb(0.0f) : Rgb(Vec3f(sum / double(around.size())));
}

int light_count(const LightSource& source, const SourceRule& rule) {
    const double wanted = std::max({double(rule.least_lights), source.share / rule.fraction_per_light,
                                    source.solid_angle / rule.solid_angle_of_a_light});
    return static_cast<int>(std::ceil(std::min(wanted, double(rule.most_lights)) * rule.direction_factor));
}

double light_of(const Vec3d& irradiance) {
    return double(luminance(Rgb(Vec3f(irradiance))));
}

/// Returns the number of splits along each edge of a pixel.
///
/// share  of the environment's light.
int pixel_splits(double share, double solid_angle, const SourceRule& rule) {
    const double parts = rule.direction_factor * std::max(share / rule.fraction_per_direction,
                                                          solid_angle / rule.solid_angle_per_direction);
    const double most = rule.most_splits * std::sqrt(rule.direction_factor);
    return static_cast<int>(std::ceil(std::clamp(std::sqrt(parts), 1.0, most)));
}

/// Appends a pixel of uniform radiance, divided into splits x splits parts.
void append_pixel_parts(const LatLongImage& image, std::size_t pixel, const Rgb& radiance, int splits,
                        std::vector<DirectionalLight>& parts) {
    const int width = image.width * splits, height = image.height * splits;
    const int first_row = int(pixel) / image.width * splits, first_column = int(pixel) % image.width * splits;
    for (int row = first_row; row < first_row + splits; ++row) {
        const float solid_angle = float(lat_long_pixel_solid_angle(row, width, height));
        for (int column = first_column; column < first_column + splits; ++column)
            parts.push_back({Vec3f(lat_long_direction((column + 0.5) / width, (row + 0.5) / height)),
                             radiance * solid_angle});
    }
}

/// A cluster: parts [begin, end) of all.
struct Piece {
    std::size_t begin, end;
    double importance;
    int axis;    ///< Axis of the largest extent.
    int number;  ///< Order of creation: breaks ties.

    bool operator<(const Piece& other) const {  // The largest is divided next.
        return importance != other.importance ? importance < other.importance : number > other.number;
    }
};

Piece piece_of(std::span<const DirectionalLight> parts, std::size_t begin, std::size_t end, int number) {
    Vec3d lower(2.0), upper(-2.0);
    double light = 0;
    for (const DirectionalLight& part : parts.subspan(begin, end - begin)) {
        light += double(luminance(part.irradiance));
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], double(part.direction[axis]));
            upper[axis] = std::max(upper[axis], double(part.direction[axis]));
        }
    }
    const Vec3d extent = upper - lower;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    return {begin, end, end - begin > 1 ? light * extent[axis] : -1, axis, number};
}

/// Returns the position that divides sorted parts into halves of about equal light; neither half is empty.
std::size_t middle_of(std::span<const DirectionalLight> parts, const Piece& piece) {
    double light = 0, so_far = 0;
    for (std::size_t i = piece.begin; i < piece.end; ++i) light += double(luminance(parts[i].irradiance));
    std::size_t cut = piece.begin;
    while (cut < piece.end && so_far < light / 2) so_far += double(luminance(parts[cut++].irradiance));
    return std::clamp(cut, piece.begin + 1, piece.end - 1);
}

DirectionalLight whole(std::span<const DirectionalLight> parts) {
    Vec3d irradiance(0.0), direction(0.0);
    for (const DirectionalLight& part : parts) {
        irradiance += Vec3d(part.irradiance);
        direction += Vec3d(part.direction) * double(luminance(part.irradiance));
    }
    if (!(direction.length() > 0)) direction = Vec3d(parts.front().direction);
    return {Vec3f(direction.normalized()), Rgb(Vec3f(irradiance))};
}

LightSource disc_source(const SunDisc& disc) {
    LightSource source;
    for (const Vec3f& direction : disc_directions(disc, disc_parts))
        source.parts.push_back({direction, disc.irradiance / float(disc_parts)});
    source.solid_angle = 2 * pi * (1 - std::cos(double(disc.angular_radius)));
    return source;
}

}  // namespace

std::vector<DirectionalLight> reduced_lights(std::span<const DirectionalLight> parts, int count) {
    assert(count >= 1);
    std::vector<DirectionalLight> sorted(parts.begin(), parts.end());
    if (sorted.size() <= std::size_t(count)) return sorted;
    std::priority_queue<Piece> pieces;
    int made = 0;
    pieces.push(piece_of(sorted, 0, sorted.size(), made++));
    while (pieces.size() < std::size_t(count)) {
        const Piece piece = pieces.top();
        if (piece.importance < 0) break;  // Only single parts remain.
        pieces.pop();
        std::stable_sort(sorted.begin() + std::ptrdiff_t(piece.begin),
                         sorted.begin() + std::ptrdiff_t(piece.end),
                         [&](const DirectionalLight& a, const DirectionalLight& b) {
                             return a.direction[piece.axis] < b.direction[piece.axis];
                         });
        const std::size_t cut = middle_of(sorted, piece);
        pieces.push(piece_of(sorted, piece.begin, cut, made++));
        pieces.push(piece_of(sorted, cut, piece.end, made++));
    }
    std::vector<Piece> all;
    for (; !pieces.empty(); pieces.pop()) all.push_back(pieces.top());
    std::sort(all.begin(), all.end(), [](const Piece& a, const Piece& b) { return a.begin < b.begin; });
    std::vector<DirectionalLight> lights;
    for (const Piece& piece : all)
        lights.push_back(whole(std::span(sorted).subspan(piece.begin, piece.end - piece.begin)));
    return lights;
}

SplitLight split_light(const Environment& environment, const SourceRule& rule) {
    SplitLight split;
    const LatLongImage& image = environment.image;
    double total = 0;
    const auto solid_angle = [&](std::size_t pixel) {
        return lat_long_pixel_solid_angle(int(pixel) / image.width, image.width, image.height);
    };
    std::vector<double> of_row(std::size_t(image.height), 0.0);
    tbb::parallel_for(0, image.height, [&](int row) {
        double& sum = of_row[std::size_t(row)];
        const Rgb* const pixels = image.pixels.data() + std::size_t(row) * std::size_t(image.width);
        for (int column = 0; column < image.width; ++column) sum += double(luminance(pixels[column]));
    });
    for (int row = 0; row < image.height; ++row)
        total += of_row[std::size_t(row)] * lat_long_pixel_solid_angle(row, image.width, image.height);
    for (const SunDisc& sun : environment.suns) total += double(luminance(sun.irradiance));
    std::vector<DimmedPixel> dimmed;
    if (!(total > 0)) {
        split.smooth = smooth_image(image, {});
        return split;
    }

    for (const SunDisc& sun : environment.suns) {
        if (!(luminance(sun.irradiance) > 0)) continue;
        LightSource source = disc_source(sun);
        source.share = double(luminance(sun.irradiance)) / total;
        const int count = light_count(source, rule);
        for (const Vec3f& direction : disc_directions(sun, count))
            source.lights.push_back({direction, sun.irradiance / float(count)});
        split.sources.push_back(std::move(source));
    }
    for (const std::vector<std::size_t>& region : bright_regions(image, rule.threshold * total / (4 * pi))) {
        const Rgb level = surrounding_level(image, region);
        LightSource source;
        Vec3d irradiance(0.0);
        for (const std::size_t pixel : region) {
            const Rgb above = without_negative(image.pixels[pixel] - level);
            source.solid_angle += solid_angle(pixel);
            if (above == Rgb(0.0f)) continue;
            const Vec3d of_pixel = Vec3d(above) * solid_angle(pixel);
            append_pixel_parts(image, pixel, above,
                               pixel_splits(light_of(of_pixel) / total, solid_angle(pixel), rule),
                               source.parts);
            irradiance += of_pixel;
        }
        source.share = light_of(irradiance) / total;
        if (!(source.share >= rule.least_share)) continue;
        for (const std::size_t pixel : region)
            dimmed.push_back({pixel, image.pixels[pixel] - without_negative(image.pixels[pixel] - level)});
        source.lights = reduced_lights(source.parts, light_count(source, rule));
        split.sources.push_back(std::move(source));
    }
    split.smooth = smooth_image(image, std::move(dimmed));
    return split;
}

std::vector<DirectionalLight> all_lights(std::span<const LightSource> sources) {
    std::vector<DirectionalLight> lights;
    for (const LightSource& source : sources)
        lights.insert(lights.end(), source.lights.begin(), source.lights.end());
    return lights;
}

}  // namespace haarfield
