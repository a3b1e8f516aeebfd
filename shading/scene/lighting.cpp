#include "shading/scene/lighting.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>

namespace haarfield {
namespace {

// The solid angle in which a pixel and a texel overlap has a closed form; energy is distributed accordingly.
//
// By symmetry, a task is one octant of the longitudes on one hemisphere. theta, from 0 to 45 degrees, is the
// angle from the axis of a side face, to one side. Coordinates are in units of the cube's half edge. A point
// on the side face has a `height` above the equator. A point on the cap (+y or -y) has the distances
// `forward` and `sideways` from the pole, along the axis and perpendicular to it. Let s be the sine of the
// absolute latitude. Between two meridians, the solid angle below a curve s(theta) is the integral of s. The
// edges of a texel are
//
//     height = h:    s = h / sqrt(h^2 + 1 / cos^2 theta),   integral of s = asin(h sin theta / sqrt(1 + h^2))
//     forward = f:   s = 1 / sqrt(1 + f^2 / cos^2 theta),   integral of s = asin(sin theta / sqrt(1 + f^2))
//     sideways = w:  s = 1 / sqrt(1 + w^2 / sin^2 theta),   integral of s = -asin(cos theta / sqrt(1 + w^2))
//
// and the edges of a pixel are meridians and s = constant.

struct Energy {
    double red = 0, green = 0, blue = 0;  ///< Radiance * solid angle.
};

struct Task {
    int quarter;     ///< theta = 0 is at quarter * 90 degrees of longitude.
    int turn;        ///< theta grows with longitude (+1) or against it (-1).
    int hemisphere;  ///< +1 upper, -1 lower.

    Vec3d forward() const {
        constexpr std::array<std::array<int, 2>, 4> axes{{{0, 1}, {1, 0}, {0, -1}, {-1, 0}}};
        const auto [x, z] = axes[std::size_t(quarter)];
        return Vec3d(x, 0, z);
    }
    Vec3d sideways() const { return Vec3d(forward().z, 0, -forward().x) * turn; }
    Vec3d up() const { return Vec3d(0, hemisphere, 0); }
    int side_face() const { return cubemap_point(forward()).face; }
    int cap_face() const { return cubemap_point(up()).face; }
};

/// Returns the index of a texel in the task's two faces: its side face, then its cap.
std::size_t texel_of(const Task& task, const Vec3d& direction, int size) {
    const CubemapPoint point = cubemap_point(direction);
    const auto index = [&](double u) { return std::clamp(int((u + 1) / 2 * size), 0, size - 1); };
    const int face = point.face == task.cap_face() ? 1 : 0;
    return std::size_t((face * size + index(point.v)) * size + index(point.u));
}

/// A region between two meridians.
struct Wedge {
    double from, to;     ///< Range of theta. [rad]
    std::size_t column;  ///< Column of pixels.
};

/// Divides a task's octant at the meridians between pixels, and also at theta = atan(line).
std::vector<Wedge> wedges(const Task& task, int width, const std::vector<double>& lines) {
    std::vector<double> angles{0, pi / 4};
    for (int column = 0; column < width; ++column) {
        const Vec3d meridian = lat_long_direction(double(column) / width, 0.5);
        const double forward = meridian.dot(task.forward()), sideways = meridian.dot(task.sideways());
        if (sideways > 0 && sideways < forward) angles.push_back(std::atan2(sideways, forward));
    }
    for (const double line : lines)
        if (line > 0 && line < 1) angles.push_back(std::atan(line));
    std::sort(angles.begin(), angles.end());

    std::vector<Wedge> result;
    for (std::size_t i = 0; i + 1 < angles.size(); ++i) {
        if (angles[i + 1] - angles[i] < 1e-12) continue;
        const double middle = (angles[i] + angles[i + 1]) / 2;
        double x, y;
        lat_long_point(task.forward() * std::cos(middle) + task.sideways() * std::sin(middle), x, y);
        result.push_back({angles[i], angles[i + 1], std::size_t(std::min(int(x * width), width - 1))});
    }
    return result;
}

/// A row of pixels, or its fraction in the hemisphere, by its edge towards the pole.
struct PixelRow {
    double sine;    ///< s at the edge.
    double radius;  ///< Distance of the edge from the pole in the cap's plane.
    std::size_t row;
};

/// Returns the rows from the equator to the pole.
std::vector<PixelRow> pixel_rows(int hemisphere, int height) {
    std::vector<PixelRow> rows;
    for (int i = height / 2; i < height; ++i) {
        const double latitude = pi * (double(i + 1) / height - 0.5);
        const bool last = i + 1 == height;
        rows.push_back({last ? 1.0 : std::sin(latitude), last ? 0.0 : 1 / std::tan(latitude),
                        std::size_t(hemisphere > 0 ? height - 1 - i : i)});
    }
    return rows;
}

/// Returns the solid angle between the equator and the lower of height = h and s = sine.
double solid_angle_below(const Wedge& wedge, double h, double sine) {
    // The curve height = h falls towards the corner of the face and meets s = sine at `meeting`.
    if (h <= 0) return 0;
    const double cosine = sine < 1 ? sine / (h * std::sqrt(1 - sine * sine)) : 2.0;
    const double meeting = std::clamp(cosine < 1 ? std::acos(cosine) : 0.0, wedge.from, wedge.to);
    const double scale = h / std::sqrt(1 + h * h);
    return sine * (meeting - wedge.from) +
           (std::asin(scale * std::sin(wedge.to)) - std::asin(scale * std::sin(meeting)));
}

/// Returns the solid angle nearer to the pole than forward = f, sideways = w and the circle of `radius`.
double solid_angle_round_pole(const Wedge& wedge, double f, double w, double radius) {
    if (f <= 0 || w <= 0 || radius <= 0) return 0;
    const double above_circle = 1 - 1 / std::sqrt(1 + radius * radius);
    const double corner = std::clamp(std::atan2(w, f), wedge.from, wedge.to);
    double sum = 0;
    if (corner > wedge.from) {  // The edge is forward = f, inside the circle up to `meeting`.
        const double meeting = std::clamp(f < radius ? std::acos(f / radius) : 0.0, wedge.from, corner);
        const double scale = 1 / std::sqrt(1 + f * f);
        sum += (meeting - wedge.from) -
               (std::asin(scale * std::sin(meeting)) - std::asin(scale * std::sin(wedge.from)));
        sum += above_circle * (corner - meeting);
    }
    if (corner < wedge.to) {  // The edge is sideways = w, inside the circle from `meeting`.
        const double meeting = std::clamp(w < radius ? std::asin(w / radius) : pi / 2, corner, wedge.to);
        const double scale = 1 / std::sqrt(1 + w * w);
        sum += above_circle * (meeting - corner);
        sum += (wedge.to - meeting) +
               (std::asin(scale * std::cos(wedge.to)) - std::asin(scale * std::cos(meeting)));
    }
    return sum;
}

/// Collects the energy that the texels of a task's two faces receive.
class Collector {
public:
    Collector(const Task& task, const LatLongImage& image, int size, const std::stop_token& stop)
        : task_(task),
          image_(image),
          size_(size),
          stop_(stop),
          rows_(pixel_rows(task.hemisphere, image.height)),
          energy_(2 * std::size_t(size) * std::size_t(size)) {
        // Lines between texels, from the centre of a face outwards; for a single texel, its half.
        for (int i = size / 2; i <= size; ++i) lines_.push_back(std::max(2.0 * i / size - 1, 0.0));
    }

    std::vector<Energy> collect() && {
        for (const Wedge& wedge : wedges(task_, image_.width, lines_))
            if (!stop_.stop_requested()) collect_on_side(wedge);
        for (const Wedge& wedge : wedges(task_, image_.width, {}))
            if (!stop_.stop_requested()) collect_on_cap(wedge);
        return std::move(energy_);
    }

private:
    void add(std::size_t texel, const Wedge& wedge, const PixelRow& row, double solid_angle) {
        if (!(solid_angle > 0)) return;  // Rounding.
        const Rgb& radiance = image_.pixels[row.row * std::size_t(image_.width) + wedge.column];
        energy_[texel].red += solid_angle * double(radiance.x);
        energy_[texel].green += solid_angle * double(radiance.y);
        energy_[texel].blue += solid_angle * double(radiance.z);
    }

    void collect_on_side(const Wedge& wedge) {
        const Vec3d outwards = task_.forward() + task_.sideways() * std::tan((wedge.from + wedge.to) / 2);
        const auto sine = [](double height, double theta) {
            return height / std::hypot(height, 1 / std::cos(theta));
        };
        std::size_t first = 0;
        for (std::size_t i = 0; i + 1 < lines_.size(); ++i) {
            const double low = lines_[i], high = lines_[i + 1];
            const std::size_t texel = texel_of(task_, outwards + task_.up() * ((low + high) / 2), size_);
            const double lowest = sine(low, wedge.to), highest = sine(high, wedge.from);
            while (rows_[first].sine <= lowest) ++first;
            double below = 0;
            for (std::size_t row = first; row < rows_.size(); ++row) {
                const double s = rows_[row].sine;
                const double next = solid_angle_below(wedge, high, s) - solid_angle_below(wedge, low, s);
                add(texel, wedge, rows_[row], next - below);
                below = next;
                if (s >= highest) break;
            }
        }
    }

    void collect_on_cap(const Wedge& wedge) {
        const double lines_to_pole = double(lines_.size() - 1);
        const auto line_before = [&](double w) {
            return std::min(std::size_t(w * lines_to_pole), lines_.size() - 2);
        };
        for (std::size_t i = 0; i + 1 < lines_.size(); ++i) {
            const double f0 = lines_[i], f1 = lines_[i + 1];
            const std::size_t last = line_before(f1 * std::tan(wedge.to));
            for (std::size_t j = line_before(f0 * std::tan(wedge.from)); j <= last; ++j)
                collect_on_cap_texel(wedge, f0, f1, lines_[j], lines_[j + 1]);
        }
    }

    void collect_on_cap_texel(const Wedge& wedge, double f0, double f1, double w0, double w1) {
        const std::size_t texel = texel_of(
            task_, task_.up() + task_.forward() * ((f0 + f1) / 2) + task_.sideways() * ((w0 + w1) / 2),
            size_);
        const double nearest = std::max(f0 / std::cos(wedge.from), w0 / std::sin(wedge.to));
        const double farthest =
            std::min(f1 / std::cos(wedge.to), wedge.from > 0 ? w1 / std::sin(wedge.from) : 2.0);
        if (!(nearest < farthest)) return;
        const auto within = [&](double radius) {
            return (solid_angle_round_pole(wedge, f1, w1, radius) -
                    solid_angle_round_pole(wedge, f0, w1, radius)) -
                   (solid_angle_round_pole(wedge, f1, w0, radius) -
                    solid_angle_round_pole(wedge, f0, w0, radius));
        };
        auto row = std::partition_point(rows_.begin(), rows_.end(),
                                        [&](const PixelRow& r) { return r.radius >= farthest; });
        double remaining = within(2);  // Beyond the corner of the face.
        for (; row != rows_.end(); ++row) {
            const double next = row->radius > nearest ? within(row->radius) : 0.0;
            add(texel, wedge, *row, remaining - next);
            remaining = next;
            if (row->radius <= nearest) break;
        }
    }

    Task task_;
    const LatLongImage& image_;
    int size_;
    const std::stop_token& stop_;
    std::vector<PixelRow> rows_;
    std::vector<double> lines_;
    std::vector<Energy> energy_;
};

}  // namespace

std::vector<Rgb> lighting_texels(const LatLongImage& environment, int size, const std::stop_token& stop) {
    assert(std::has_single_bit(unsigned(size)));
    assert(environment.width > 0 && environment.height > 0 &&
           environment.pixels.size() == std::size_t(environment.width) * std::size_t(environment.height));
    std::array<Task, 16> tasks;
    std::array<std::vector<Energy>, 16> parts;
    for (int i = 0; i < 16; ++i) tasks[std::size_t(i)] = {i / 4, i & 1 ? -1 : +1, i & 2 ? -1 : +1};
    tbb::parallel_for(std::size_t(0), tasks.size(), [&](std::size_t i) {
        parts[i] = Collector(tasks[i], environment, size, stop).collect();
    });

    // Several tasks contribute to texels on the diagonals and in the middle: sums are in task order.
    const std::size_t face_texels = std::size_t(size) * std::size_t(size);
    std::vector<Energy> sums(cubemap_faces * face_texels);
    for (std::size_t i = 0; i < tasks.size(); ++i)
        for (const int part : {0, 1}) {
            const std::size_t face = std::size_t(part == 0 ? tasks[i].side_face() : tasks[i].cap_face());
            for (std::size_t texel = 0; texel < face_texels; ++texel) {
                const Energy& from = parts[i][std::size_t(part) * face_texels + texel];
                Energy& to = sums[face * face_texels + texel];
                to.red += from.red;
                to.green += from.green;
                to.blue += from.blue;
            }
        }

    std::vector<Rgb> texels(sums.size());
    const double scale = double(face_texels);
    for (std::size_t i = 0; i < sums.size(); ++i)
        texels[i] =
            Rgb(float(sums[i].red * scale), float(sums[i].green * scale), float(sums[i].blue * scale));
    return texels;
}

RgbCubemapTree lighting_tree(const LatLongImage& environment, int size, const Truncation& truncation,
                             const std::stop_token& stop) {
    return haar_cubemap<Rgb>(lighting_texels(environment, size, stop), size, truncation);
}

}  // namespace haarfield
