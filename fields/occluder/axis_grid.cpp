#include "fields/occluder/axis_grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace haarfield {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Point = std::array<float, 2>;  // across and up

/// A mesh projected along an axis.
struct Projection {
    std::span<const Vec3f> positions;
    std::span<const Triangle> triangles;
    AxisFrame frame;

    std::array<Point, 3> operator()(std::uint32_t triangle) const {
        std::array<Point, 3> points;
        for (std::size_t v = 0; v < 3; ++v) {
            const Vec3f& position = positions[triangles[triangle][v]];
            points[v] = {position[frame.across], position[frame.up]};
        }
        return points;
    }
};

struct Box {
    Point lower{INFINITY, INFINITY}, upper{-INFINITY, -INFINITY};

    void extend(const Point& point) {
        for (std::size_t k = 0; k < 2; ++k) {
            lower[k] = std::min(lower[k], point[k]);
            upper[k] = std::max(upper[k], point[k]);
        }
    }
    double extent(std::size_t k) const { return double(upper[k]) - double(lower[k]); }
};

Box box_of(const std::array<Point, 3>& points) {
    Box box;
    for (const Point& point : points) box.extend(point);
    return box;
}

/// Returns the longest edge of a projected triangle.
std::array<double, 2> longest_edge(const std::array<Point, 3>& points) {
    std::array<double, 2> longest{};
    for (std::size_t v = 0; v < 3; ++v) {
        const Point &from = points[v], &to = points[(v + 1) % 3];
        const std::array<double, 2> edge{double(to[0]) - double(from[0]), double(to[1]) - double(from[1])};
        if (std::hypot(edge[0], edge[1]) > std::hypot(longest[0], longest[1])) longest = edge;
    }
    return longest;
}

/// A long triangle with its sort keys: the centre of its box, and the direction of its longest edge as an
/// angle modulo pi.
struct Sorted {
    std::array<float, 3> key;
    std::uint32_t triangle;
};

/// Builds the tree of LongTriangles.
class TreeBuilder {
public:
    TreeBuilder(const Projection& projection, const std::vector<std::uint32_t>& triangles)
        : projection_(projection) {
        sorted_.reserve(triangles.size());
        for (const std::uint32_t t : triangles) {
            const std::array<Point, 3> points = projection_(t);
            const Box box = box_of(points);
            const auto [x, y] = longest_edge(points);
            const double angle = std::atan2(y, x);
            sorted_.push_back({{box.lower[0] / 2 + box.upper[0] / 2, box.lower[1] / 2 + box.upper[1] / 2,
                                static_cast<float>(angle < 0 ? angle + M_PI : angle)},
                               t});
        }
    }

    LongTriangles tree() {
        if (!sorted_.empty()) add(sorted_);
        made_.triangle.reserve(sorted_.size());
        for (const Sorted& item : sorted_) made_.triangle.push_back(item.triangle);
        return std::move(made_);
    }

private:
    void add(std::span<Sorted> items) {
        const std::size_t number = made_.nodes.size();
        made_.nodes.push_back(bounds_of(items));
        if (items.size() <= LongTriangles::leaf_size) {
            made_.nodes[number].first = static_cast<std::uint32_t>(items.data() - sorted_.data());
            made_.nodes[number].count = static_cast<std::uint32_t>(items.size());
        } else {
            const std::size_t half = items.size() / 2;
            halve(items);
            add(items.first(half));
            add(items.subspan(half));
        }
        made_.nodes[number].next = static_cast<std::uint32_t>(made_.nodes.size());
    }

    /// Splits at the median of the key whose halves have the smallest bounds.
    void halve(std::span<Sorted> items) const {
        const std::size_t half = items.size() / 2, keys = std::tuple_size_v<decltype(Sorted::key)>;
        const auto split = [&](std::size_t k) {
            std::nth_element(items.begin(), items.begin() + std::ptrdiff_t(half), items.end(),
                             [k](const Sorted& a, const Sorted& b) {
                                 return a.key[k] != b.key[k] ? a.key[k] < b.key[k] : a.triangle < b.triangle;
                             });
        };
        std::size_t best = 0;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < keys; ++k) {
            split(k);
            const double area =
                area_of(bounds_of(items.first(half))) + area_of(bounds_of(items.subspan(half)));
            if (area < least) {
                least = area;
                best = k;
            }
        }
        if (best + 1 != keys) split(best);
    }

    /// Returns an upper bound of the area in which queries enter a node.
    static double area_of(const LongTriangles::Node& node) {
        const double width = double(node.upper[0]) - double(node.lower[0]),
                     height = double(node.upper[1]) - double(node.lower[1]),
                     strip = double(node.strip_upper) - double(node.strip_lower);
        return std::min(width * height, strip * std::hypot(width, height));
    }

    LongTriangles::Node bounds_of(std::span<const Sorted> items) const {
        Box box;
        std::array<double, 2> along{};
        for (const Sorted& item : items) {
            const std::array<Point, 3> points = projection_(item.triangle);
            for (const Point& point : points) box.extend(point);
            const std::array<double, 2> edge = longest_edge(points);
            if (std::hypot(edge[0], edge[1]) > std::hypot(along[0], along[1])) along = edge;
        }
        LongTriangles::Node node{box.lower, box.upper, {0, 0}, 0, 0, 0, 0, 0};
        const double length = std::hypot(along[0], along[1]);
        if (!(length > 0)) return node;
        node.normal = {static_cast<float>(-along[1] / length), static_cast<float>(along[0] / length)};
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const Sorted& item : items)
            for (const Point& point : projection_(item.triangle)) {
                const double at =
                    double(node.normal[0]) * double(point[0]) + double(node.normal[1]) * double(point[1]);
                low = std::min(low, at);
                high = std::max(high, at);
            }
        // Callers round coordinates relative to a point of the box to floats.
        constexpr double rounding = 4 * std::numeric_limits<float>::epsilon();
        const double margin = rounding * (box.extent(0) + box.extent(1));
        node.strip_lower = std::nextafter(static_cast<float>(low - margin), -INFINITY);
        node.strip_upper = std::nextafter(static_cast<float>(high + margin), INFINITY);
        return node;
    }

    Projection projection_;
    std::vector<Sorted> sorted_;
    LongTriangles made_;
};

/// Returns an empty grid over the bounds of all used vertices, with about one cell per triangle.
AxisGrid empty_grid(const Projection& projection) {
    Box box;
    for (std::uint32_t t = 0; t < projection.triangles.size(); ++t)
        for (const Point& point : projection(t)) box.extend(point);
    AxisGrid grid;
    grid.cells = std::clamp(static_cast<int>(std::sqrt(double(projection.triangles.size()))), 1, 512);
    if (projection.triangles.empty()) return grid;
    grid.lower = box.lower;
    for (std::size_t k = 0; k < 2; ++k) {
        // An extent close to zero would result in an infinite number.
        const auto number = static_cast<float>(grid.cells / box.extent(k));
        grid.cells_per_metre[k] = std::isfinite(number) ? number : 0.0f;
    }
    return grid;
}

/// The cells that a triangle's box touches.
struct CellRange {
    std::array<int, 2> low, high;

    CellRange(const AxisGrid& grid, const Box& box) {
        for (std::size_t k = 0; k < 2; ++k) {
            low[k] = grid.cell(double(box.lower[k]), k);
            high[k] = grid.cell(double(box.upper[k]), k);
        }
    }
    std::size_t count() const {
        return static_cast<std::size_t>(high[0] - low[0] + 1) *
               static_cast<std::size_t>(high[1] - low[1] + 1);
    }
};

}  // namespace

int AxisGrid::cell(double coordinate, std::size_t k) const {
    return static_cast<int>(std::clamp((coordinate - double(lower[k])) * double(cells_per_metre[k]), 0.0,
                                       static_cast<double>(cells - 1)));
}

AxisGrid axis_grid(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                   const AxisFrame& frame) {
    assert(triangles.size() < (std::size_t(1) << 28));  // all entries are counted in 32 bits
    const Projection projection{positions, triangles, frame};
    AxisGrid grid = empty_grid(projection);
    const auto count = static_cast<std::uint32_t>(triangles.size());
    const auto for_each_cell = [&](std::uint32_t t, auto&& visit) {
        const CellRange range(grid, box_of(projection(t)));
        if (range.count() > AxisGrid::most_cells) return false;
        for (int y = range.low[1]; y <= range.high[1]; ++y)
            for (int x = range.low[0]; x <= range.high[0]; ++x)
                visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.cells) +
                      static_cast<std::size_t>(x));
        return true;
    };
    grid.first.assign(std::size_t(grid.cells) * std::size_t(grid.cells) + 1, 0);
    std::vector<std::uint32_t> long_ones;
    for (std::uint32_t t = 0; t < count; ++t)
        if (!for_each_cell(t, [&](std::size_t cell) { ++grid.first[cell + 1]; })) long_ones.push_back(t);
    std::partial_sum(grid.first.begin(), grid.first.end(), grid.first.begin());
    grid.triangle.resize(grid.first.back());
    std::vector<std::uint32_t> next(grid.first.begin(), grid.first.end() - 1);
    for (std::uint32_t t = 0; t < count; ++t)
        for_each_cell(t, [&](std::size_t cell) { grid.triangle[next[cell]++] = t; });
    grid.long_triangles = TreeBuilder(projection, long_ones).tree();
    return grid;
}

}  // namespace haarfield
