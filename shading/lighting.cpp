#include "shading/lighting.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace haarfield {
namespace {

// The sphere is swept by narrow strips between two meridians. Where a strip's middle meridian crosses a
// boundary of a texel or of a pixel is known in closed form, so that the strip falls apart into pieces
// that lie in one texel and in one pixel; a piece from sine of latitude s0 to s1 has the solid angle
// width * (s1 - s0). For every pixel these add up to its solid angle exactly, whatever the texels are:
// no energy is lost. For a texel they add up to its solid angle up to the width of the strips, which is
// divided out at the end.
//
// By symmetry, a task is one quarter of the longitudes (about the middle of one side face) on one
// hemisphere. There, in units of the cube's half edge: `forward` is the distance along the side face's
// axis, `slope` the tangent of the longitude from it, and sideways = forward * slope.

/// Strips per texel column at the least; the texels' own solid angles then err by 1e-3.
inline constexpr int strips_per_texel = 12;

struct Collected {
    double red = 0, green = 0, blue = 0;  ///< Radiance * solid angle.
    double solid_angle = 0;
};

/// Where a meridian leaves a texel, on the way from the equator to the pole.
struct Leaving {
    double sine;        ///< Of the latitude.
    std::size_t texel;  ///< In the task's two faces: its side face, then its cap.
};

struct Task {
    int quarter;     ///< Longitudes within 45 degrees of quarter * 90 degrees.
    int hemisphere;  ///< +1 upper, -1 lower.

    Vec3d forward() const {
        constexpr std::array<Vec3d, 4> axes{Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(0, 0, -1), Vec3d(-1, 0, 0)};
        return axes[std::size_t(quarter)];
    }
    /// Where longitude grows to.
    Vec3d sideways() const {
        const Vec3d f = forward();
        return {f.z, 0, -f.x};
    }
    int side_face() const { return cubemap_point(forward()).face; }
    int cap_face() const { return hemisphere > 0 ? 2 : 3; }
};

std::size_t texel_of(const Task& task, const Vec3d& direction, int size) {
    const CubemapPoint point = cubemap_point(direction);
    const auto index = [&](double u) { return std::clamp(int((u + 1) / 2 * size), 0, size - 1); };
    const int face = point.face == task.cap_face() ? 1 : 0;
    return std::size_t((face * size + index(point.v)) * size + index(point.u));
}

/// The texels along the meridian, from the equator to the pole.
void cross_texels(const Task& task, double slope, int size, std::vector<Leaving>& leaving) {
    leaving.clear();
    const Vec3d outwards = task.forward() + task.sideways() * slope;
    const Vec3d up(0, task.hemisphere, 0);
    const double length2 = 1 + slope * slope;

    // The side face: rows at heights of whole texels above the equator; its middle is a boundary unless
    // it is a single texel.
    double below = 0;
    for (int row = size / 2 + 1; row <= size; ++row) {
        const double height = std::min(2.0 * row / size - 1, 1.0);
        leaving.push_back({height / std::sqrt(length2 + height * height),
                           texel_of(task, outwards + up * ((below + height) / 2), size)});
        below = height;
    }
    // The cap: from its edge, forward = 1, to the pole, forward = 0, through the next of the lines across
    // and of the lines along.
    const double steepness = std::abs(slope);
    int across = size - 1, along = size;
    while (2.0 * along / size - 1 >= steepness && along > 0) --along;
    double outer = 1;
    while (outer > 0) {
        const double line_across = std::max(2.0 * across / size - 1, 0.0);
        const double line_along = steepness > 0 ? std::max((2.0 * along / size - 1) / steepness, 0.0) : 0.0;
        const double inner = std::max(line_across, line_along);
        if (line_across >= inner) --across;
        if (line_along >= inner) --along;
        leaving.push_back({1 / std::sqrt(1 + inner * inner * length2),
                           texel_of(task, outwards * ((outer + inner) / 2) + up, size)});
        outer = inner;
    }
}

/// Slopes between which a strip lies in one column of texels of the side face and one of pixels.
std::vector<double> strip_boundaries(const Task& task, int width, int size) {
    std::vector<double> slopes;
    // At least so many, because the middle of a cap sees its few texels under wide angles.
    const int strips = std::max(size * strips_per_texel, 192);
    for (int i = 0; i <= strips; ++i) slopes.push_back(2.0 * i / strips - 1);
    for (int column = 0; column < width; ++column) {
        const Vec3d meridian = lat_long_direction(double(column) / width, 0.5);
        const double along = meridian.dot(task.forward()), across = meridian.dot(task.sideways());
        if (along > std::abs(across)) slopes.push_back(across / along);
    }
    std::sort(slopes.begin(), slopes.end());
    return slopes;
}

/// The part of a row of pixels that lies in a hemisphere.
struct PixelRow {
    double sine;  ///< Of the latitude where it ends on the way to the pole, without sign.
    std::size_t row;
};

std::vector<PixelRow> pixel_rows(int hemisphere, int height) {
    std::vector<PixelRow> rows;
    for (int i = height / 2; i < height; ++i) {
        const double sine = i + 1 == height ? 1.0 : std::sin(pi * (double(i + 1) / height - 0.5));
        rows.push_back({sine, std::size_t(hemisphere > 0 ? height - 1 - i : i)});
    }
    return rows;
}

/// Energy and solid angle that the texels of the task's two faces collect on it.
std::vector<Collected> collect(const Task& task, const LatLongImage& image, int size) {
    std::vector<Collected> texels(2 * std::size_t(size) * std::size_t(size));
    const std::vector<double> slopes = strip_boundaries(task, image.width, size);
    const std::vector<PixelRow> rows = pixel_rows(task.hemisphere, image.height);
    std::vector<Leaving> leaving;
    for (std::size_t strip = 0; strip + 1 < slopes.size(); ++strip) {
        const double width = std::atan(slopes[strip + 1]) - std::atan(slopes[strip]);
        if (!(width > 1e-12)) continue;
        const double slope = (slopes[strip] + slopes[strip + 1]) / 2;
        cross_texels(task, slope, size, leaving);

        double x, y;
        lat_long_point(task.forward() + task.sideways() * slope, x, y);
        const std::size_t column = std::size_t(std::clamp(int(x * image.width), 0, image.width - 1));
        double sine = 0;
        for (std::size_t i = 0, j = 0; i < leaving.size() && j < rows.size();) {
            const double next = std::min(leaving[i].sine, rows[j].sine);
            const double solid_angle = width * (next - sine);
            const Rgb& radiance = image.pixels[rows[j].row * std::size_t(image.width) + column];
            Collected& texel = texels[leaving[i].texel];
            texel.red += solid_angle * double(radiance.x);
            texel.green += solid_angle * double(radiance.y);
            texel.blue += solid_angle * double(radiance.z);
            texel.solid_angle += solid_angle;
            sine = next;
            const bool texel_ends = leaving[i].sine <= next, pixel_ends = rows[j].sine <= next;
            i += texel_ends;
            j += pixel_ends;
        }
    }
    return texels;
}

}  // namespace

std::vector<Rgb> lighting_texels(const LatLongImage& environment, int size) {
    assert(is_face_size(size));
    assert(environment.width > 0 && environment.height > 0 &&
           environment.pixels.size() == std::size_t(environment.width) * std::size_t(environment.height));
    std::array<Task, 8> tasks;
    std::array<std::vector<Collected>, 8> parts;
    for (int i = 0; i < 8; ++i) tasks[std::size_t(i)] = {i / 2, i % 2 == 0 ? +1 : -1};
    tbb::parallel_for(std::size_t(0), tasks.size(),
                      [&](std::size_t i) { parts[i] = collect(tasks[i], environment, size); });

    // Parts meet in the texels on a cap's diagonals: added in the order of the tasks.
    const std::size_t face_texels = std::size_t(size) * std::size_t(size);
    std::vector<Collected> sums(cubemap_faces * face_texels);
    for (std::size_t i = 0; i < tasks.size(); ++i)
        for (const int part : {0, 1}) {
            const std::size_t face = std::size_t(part == 0 ? tasks[i].side_face() : tasks[i].cap_face());
            for (std::size_t texel = 0; texel < face_texels; ++texel) {
                const Collected& from = parts[i][std::size_t(part) * face_texels + texel];
                Collected& to = sums[face * face_texels + texel];
                to.red += from.red;
                to.green += from.green;
                to.blue += from.blue;
                to.solid_angle += from.solid_angle;
            }
        }

    std::vector<Rgb> texels(sums.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const std::size_t texel = i % face_texels;
        const double solid_angle =
            texel_solid_angle(int(texel % std::size_t(size)), int(texel / std::size_t(size)), size);
        const double scale = double(face_texels) * solid_angle / sums[i].solid_angle;
        texels[i] =
            Rgb(float(sums[i].red * scale), float(sums[i].green * scale), float(sums[i].blue * scale));
    }
    return texels;
}

RgbCubemapTree lighting_tree(const LatLongImage& environment, int size, const Truncation& truncation) {
    return haar_cubemap<Rgb>(lighting_texels(environment, size), size, truncation);
}

}  // namespace haarfield
