#include "bridge/povray_import/surface_charts.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <unordered_set>

namespace haarfield {
namespace {

constexpr int border = 2;          // Around a chart. [texels]
constexpr int largest_side = 256;  // Of a chart without its border. [texels]
constexpr double inset = 0.05;     // Of texels from the edges of the triangles that cover them. [texels]

Vec3d normal_of(const UnchartedSurface& surface, std::size_t triangle) {
    const auto& [a, b, c] = surface.triangles[triangle];
    const Vec3d p(surface.positions[a]);
    return (Vec3d(surface.positions[b]) - p).cross(Vec3d(surface.positions[c]) - p);
}

/// The projection of a triangle: a side of a cube, and the size of texels.
struct Projection {
    int axis = 0;
    bool is_negative = false;  ///< The side faces down the axis.
    int level = 0;             ///< Binary logarithm of the texels' size in units.

    bool operator==(const Projection&) const = default;
};

/// A point of a chart. [texels]
struct ChartPoint {
    double x = 0, y = 0;
};

ChartPoint projected(const Vec3d& p, const Projection& projection, double unit) {
    const double size = std::ldexp(unit, projection.level);
    const double x = p[(projection.axis + 1) % 3] / size, y = p[(projection.axis + 2) % 3] / size;
    return {projection.is_negative ? -x : x, y};
}

std::array<ChartPoint, 3> corners_of(const UnchartedSurface& surface, std::size_t triangle,
                                     const Projection& projection, double unit) {
    std::array<ChartPoint, 3> points;
    for (std::size_t c = 0; c < 3; ++c)
        points[c] =
            projected(Vec3d(surface.positions[surface.triangles[triangle][c]]) - Vec3d(surface.positions[0]),
                      projection, unit);
    return points;
}

double area_of(const std::array<ChartPoint, 3>& p) {
    return 0.5 * ((p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[1].y - p[0].y) * (p[2].x - p[0].x));
}

/// A rectangle of texels, without its upper bounds.
struct TexelBox {
    int left = INT32_MAX, bottom = INT32_MAX, right = INT32_MIN, top = INT32_MIN;

    void add(const ChartPoint& p) {
        left = std::min(left, static_cast<int>(std::floor(p.x)));
        bottom = std::min(bottom, static_cast<int>(std::floor(p.y)));
        right = std::max(right, static_cast<int>(std::floor(p.x)) + 1);
        top = std::max(top, static_cast<int>(std::floor(p.y)) + 1);
    }
    int width() const { return right - left; }
    int height() const { return top - bottom; }
};

/// Calls `visit(x, y)` for the texels whose centres are inside a triangle.
template <class Visit>
void visit_texels(const std::array<ChartPoint, 3>& p, const Visit& visit) {
    const double orientation = area_of(p) < 0 ? -1 : 1;
    TexelBox box;
    for (const ChartPoint& corner : p) box.add(corner);
    for (int y = box.bottom; y < box.top; ++y)
        for (int x = box.left; x < box.right; ++x) {
            bool is_inside = true;
            for (std::size_t k = 0; k < 3 && is_inside; ++k) {
                const ChartPoint &a = p[k], &b = p[(k + 1) % 3];
                const double dx = b.x - a.x, dy = b.y - a.y, length = std::hypot(dx, dy);
                is_inside = orientation * (dx * (y + 0.5 - a.y) - dy * (x + 0.5 - a.x)) > inset * length;
            }
            if (is_inside) visit(x, y);
        }
}

std::uint64_t key(int x, int y) {
    return std::uint64_t(std::uint32_t(x)) << 32 | std::uint32_t(y);
}

/// A chart before its place in the image is known.
struct Chart {
    std::uint32_t surface = 0;
    Projection projection;
    std::vector<std::uint32_t> triangles;
    TexelBox box;
    ChartRectangle place;
};

/// Returns up to three neighbours of each triangle, those across its edges; -1: none.
std::vector<std::array<std::int32_t, 3>> neighbours(const UnchartedSurface& surface) {
    std::unordered_map<std::uint64_t, std::pair<std::int32_t, std::int32_t>> open;  // Triangle and edge.
    std::vector<std::array<std::int32_t, 3>> result(surface.triangles.size(), {-1, -1, -1});
    for (std::size_t t = 0; t < surface.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(surface.triangles[t][k], surface.triangles[t][(k + 1) % 3]);
            const std::uint64_t edge = std::uint64_t(low) << 32 | high;
            const auto [entry, is_new] = open.try_emplace(edge, std::int32_t(t), std::int32_t(k));
            if (is_new) continue;
            const auto [other, side] = entry->second;
            result[t][k] = other;
            result[std::size_t(other)][std::size_t(side)] = std::int32_t(t);
            open.erase(entry);
        }
    return result;
}

/// Grows charts from the triangles of a surface.
void add_charts(const UnchartedSurface& surface, std::uint32_t index, double unit,
                std::vector<Chart>& charts) {
    std::vector<Projection> projections;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const Vec3d normal = normal_of(surface, t);
        Projection projection;
        for (int axis = 1; axis < 3; ++axis)
            if (std::abs(normal[axis]) > std::abs(normal[projection.axis])) projection.axis = axis;
        projection.is_negative = normal[projection.axis] < 0;
        projection.level = std::max(
            0, static_cast<int>(std::floor(std::log2(std::max(1.0, double(surface.texels[t]) / unit)))));
        TexelBox box;
        for (const ChartPoint& p : corners_of(surface, t, projection, unit)) box.add(p);
        for (int side = std::max(box.width(), box.height()); side > largest_side; side /= 2)
            ++projection.level;
        projections.push_back(projection);
    }
    const std::vector<std::array<std::int32_t, 3>> beside = neighbours(surface);
    std::vector<std::uint8_t> is_taken(surface.triangles.size(), 0);
    std::unordered_set<std::uint64_t> covered;
    for (std::uint32_t seed = 0; seed < surface.triangles.size(); ++seed) {
        if (is_taken[seed]) continue;
        Chart chart{index, projections[seed], {}, {}, {}};
        covered.clear();
        std::vector<std::uint32_t> queue{seed};
        for (std::size_t next = 0; next < queue.size(); ++next) {
            const std::uint32_t t = queue[next];
            if (is_taken[t]) continue;
            const std::array<ChartPoint, 3> corners = corners_of(surface, t, chart.projection, unit);
            TexelBox box = chart.box;
            for (const ChartPoint& p : corners) box.add(p);
            if (!chart.triangles.empty()) {
                bool fits = std::max(box.width(), box.height()) <= largest_side;
                if (fits) visit_texels(corners, [&](int x, int y) { fits &= !covered.contains(key(x, y)); });
                if (!fits) continue;
            }
            visit_texels(corners, [&](int x, int y) { covered.insert(key(x, y)); });
            chart.box = box;
            chart.triangles.push_back(t);
            is_taken[t] = 1;
            for (const std::int32_t other : beside[t])
                if (other >= 0 && !is_taken[std::size_t(other)] &&
                    projections[std::size_t(other)] == chart.projection)
                    queue.push_back(std::uint32_t(other));
        }
        charts.push_back(std::move(chart));
    }
}

/// Places the charts on shelves. Returns the height of the image.
int place_charts(std::vector<Chart>& charts, int width) {
    std::vector<std::size_t> order(charts.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::ranges::stable_sort(order, std::ranges::greater(),
                             [&](std::size_t i) { return charts[i].box.height(); });
    int left = 0, top = 0, shelf = 0;
    for (const std::size_t i : order) {
        Chart& chart = charts[i];
        const int w = chart.box.width() + 2 * border, h = chart.box.height() + 2 * border;
        if (left + w > width) {
            left = 0;
            top += shelf;
            shelf = 0;
        }
        chart.place = {left, top, w, h, chart.surface, chart.triangles.front()};
        left += w;
        shelf = std::max(shelf, h);
    }
    return top + shelf;
}

}  // namespace

SurfaceCharts surface_charts(std::span<const UnchartedSurface> surfaces, double most) {
    double unit = INFINITY, texels = 0;
    for (const UnchartedSurface& surface : surfaces) {
        assert(surface.texels.size() == surface.triangles.size());
        for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
            const auto size = double(surface.texels[t]);
            unit = std::min(unit, size);
            texels += 0.5 * normal_of(surface, t).length() / (size * size);
        }
    }
    SurfaceCharts result;
    result.surfaces.resize(surfaces.size());
    if (!(unit < INFINITY)) return result;
    const double larger = std::sqrt(std::max(1.0, texels / most));
    std::vector<Chart> charts;
    for (std::uint32_t s = 0; s < surfaces.size(); ++s) {
        UnchartedSurface enlarged = surfaces[s];
        for (float& size : enlarged.texels) size *= static_cast<float>(larger);
        add_charts(enlarged, s, unit * larger, charts);
    }
    double area = 0;
    int widest = 0;
    for (const Chart& chart : charts) {
        area += double(chart.box.width() + 2 * border) * double(chart.box.height() + 2 * border);
        widest = std::max(widest, chart.box.width() + 2 * border);
    }
    result.width = std::max(widest, static_cast<int>(std::ceil(std::sqrt(1.1 * area))));
    result.height = place_charts(charts, result.width);
    result.covered.assign(std::size_t(result.width) * std::size_t(result.height), 0);
    for (std::uint32_t s = 0; s < surfaces.size(); ++s)
        result.surfaces[s].triangles.resize(surfaces[s].triangles.size());
    for (const Chart& chart : charts) {
        const UnchartedSurface& surface = surfaces[chart.surface];
        ChartedSurface& charted = result.surfaces[chart.surface];
        std::unordered_map<std::uint32_t, std::uint32_t> numbers;
        // Texels of the image, with y up.
        const int right = chart.place.left + border - chart.box.left,
                  up = result.height - chart.place.top - chart.place.height + border - chart.box.bottom;
        for (const std::uint32_t t : chart.triangles) {
            std::array<ChartPoint, 3> corners = corners_of(surface, t, chart.projection, unit * larger);
            for (std::size_t c = 0; c < 3; ++c) {
                const std::uint32_t original = surface.triangles[t][c];
                const auto [entry, is_new] =
                    numbers.try_emplace(original, std::uint32_t(charted.originals.size()));
                if (is_new) {
                    charted.originals.push_back(original);
                    charted.uvs.emplace_back(float((corners[c].x + right) / result.width),
                                             float((corners[c].y + up) / result.height));
                }
                charted.triangles[t][c] = entry->second;
            }
            visit_texels(corners, [&](int x, int y) {
                const auto row = std::size_t(result.height - 1 - (y + up)), column = std::size_t(x + right);
                result.covered[row * std::size_t(result.width) + column] = 1;
            });
        }
        result.rectangles.push_back(chart.place);
    }
    return result;
}

}  // namespace haarfield
