#include "fields/preparation/opaque_outline.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_plus_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polyline_simplification_2/simplify.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace haarfield {
namespace {

namespace simplification = CGAL::Polyline_simplification_2;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;
enum class Side : std::uint8_t { unknown, transparent, opaque };
using FaceBase =
    CGAL::Constrained_triangulation_face_base_2<Kernel,
                                                CGAL::Triangulation_face_base_with_info_2<Side, Kernel>>;
using Structure = CGAL::Triangulation_data_structure_2<simplification::Vertex_base_2<Kernel>, FaceBase>;
using Delaunay = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::Exact_predicates_tag>;
using Outlines = CGAL::Constrained_triangulation_plus_2<Delaunay>;

constexpr double half = 127.5;

/// Makes costs distinct, because CGAL orders vertices of equal cost by their addresses in memory.
struct DistinctCost {
    template <class Iterator>
    auto operator()(const Outlines& outlines, Iterator vertex) const {
        auto cost = simplification::Squared_distance_cost()(outlines, vertex);
        const Point& p = (*vertex)->point();
        if (cost) *cost += 1e-9 * (0.6180339887 * p.x() + p.y());
        return cost;
    }
};

OpacityMap averaged(const OpacityMap& map, int width, int height) {
    OpacityMap small{width, height, {}};
    const auto from = [](int at, int size, int of) { return static_cast<int>(std::int64_t(at) * of / size); };
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            std::int64_t sum = 0, count = 0;
            for (int y = from(row, height, map.height); y < from(row + 1, height, map.height); ++y)
                for (int x = from(column, width, map.width); x < from(column + 1, width, map.width); ++x) {
                    sum += map.opacity[std::size_t(y) * std::size_t(map.width) + std::size_t(x)];
                    ++count;
                }
            small.opacity.push_back(static_cast<std::uint8_t>((2 * sum + count) / (2 * count)));
        }
    return small;
}

/// A line along which the opacity is one half. [texels]
struct Outline {
    std::vector<Point> points;
    bool is_closed = false;
};

/// Finds the outlines in a tile. The nodes of an outline are its crossings with the edges of the lattice of
/// texel centres.
class MarchingSquares {
public:
    explicit MarchingSquares(const OpacityMap& map)
        : map_(map), links_(2 * std::size_t(map.width + 1) * std::size_t(map.height + 1), {none, none}) {
        for (int row = 0; row < map.height; ++row)
            for (int column = 0; column < map.width; ++column) link_cell(column, row);
    }

    double value(int column, int row) const {
        return map_.opacity[std::size_t(row % map_.height) * std::size_t(map_.width) +
                            std::size_t(column % map_.width)];
    }

    std::vector<Outline> outlines() {
        std::vector<Outline> found;
        // Outlines that begin at the tile's border come first. All others are closed.
        for (const bool is_closed : {false, true})
            for (std::uint32_t node = 0; node < links_.size(); ++node)
                if (links_[node][0] != none && (is_closed || links_[node][1] == none))
                    found.push_back({traced(node), is_closed});
        return found;
    }

private:
    static constexpr std::uint32_t none = UINT32_MAX;
    enum Direction : std::uint32_t { right, down };  // of a lattice edge from its first texel

    std::uint32_t node(int column, int row, Direction direction) const {
        return 2 * (std::uint32_t(row) * std::uint32_t(map_.width + 1) + std::uint32_t(column)) + direction;
    }

    Point place(std::uint32_t of) const {
        const auto across = std::uint32_t(map_.width + 1);
        const int column = static_cast<int>(of / 2 % across), row = static_cast<int>(of / 2 / across);
        const bool is_right = of % 2 == right;
        const double from = value(column, row), to = value(column + is_right, row + !is_right);
        const double share = (half - from) / (to - from);
        return {column + 0.5 + (is_right ? share : 0), row + 0.5 + (is_right ? 0 : share)};
    }

    void link(std::uint32_t a, std::uint32_t b) {
        links_[a][links_[a][0] != none] = b;
        links_[b][links_[b][0] != none] = a;
    }

    void link_cell(int column, int row) {
        const double a = value(column, row), b = value(column + 1, row), c = value(column + 1, row + 1),
                     d = value(column, row + 1);
        const std::uint32_t above = node(column, row, right), below = node(column, row + 1, right),
                            before = node(column, row, down), behind = node(column + 1, row, down);
        std::array<std::uint32_t, 4> crossed;
        std::size_t count = 0;
        if ((a > half) != (b > half)) crossed[count++] = above;
        if ((b > half) != (c > half)) crossed[count++] = behind;
        if ((c > half) != (d > half)) crossed[count++] = below;
        if ((d > half) != (a > half)) crossed[count++] = before;
        if (count == 2) link(crossed[0], crossed[1]);
        if (count != 4) return;
        // a and c are connected if the value at the saddle is on their side.
        const double saddle = (a * c - b * d) / (a + c - b - d);
        const bool is_joined = (saddle > half) == (a > half);
        link(above, is_joined ? behind : before);
        link(below, is_joined ? before : behind);
    }

    /// Follows an outline from a node, and removes its links.
    std::vector<Point> traced(std::uint32_t from) {
        std::vector<Point> points{place(from)};
        std::uint32_t at = from, last = none;
        for (;;) {
            const std::array<std::uint32_t, 2> ways = std::exchange(links_[at], {none, none});
            const std::uint32_t next = ways[0] != last ? ways[0] : ways[1];
            if (next == none || next == from) return points;
            points.push_back(place(next));
            last = at;
            at = next;
        }
    }

    const OpacityMap& map_;
    std::vector<std::array<std::uint32_t, 2>> links_;  // indexed by node
};

double area(const std::vector<Point>& points) {
    double twice = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point &p = points[i], &q = points[(i + 1) % points.size()];
        twice += p.x() * q.y() - p.y() * q.x();
    }
    return std::abs(twice) / 2;
}

/// Assigns sides to all faces, starting at one of them. The side changes at outlines.
void tell_sides(Outlines& outlines, Outlines::Face_handle from, Side side) {
    from->info() = side;
    std::vector<Outlines::Face_handle> open{from};
    while (!open.empty()) {
        const Outlines::Face_handle face = open.back();
        open.pop_back();
        for (int edge = 0; edge < 3; ++edge) {
            const Outlines::Face_handle next = face->neighbor(edge);
            if (outlines.is_infinite(next) || next->info() != Side::unknown) continue;
            const bool is_opaque = (face->info() == Side::opaque) != face->is_constrained(edge);
            next->info() = is_opaque ? Side::opaque : Side::transparent;
            open.push_back(next);
        }
    }
}

}  // namespace

bool OpacityMap::has_holes() const {
    return std::ranges::any_of(opacity, [](std::uint8_t value) { return value < half; });
}

OpaqueTile opaque_tile(const OpacityMap& map, double tolerance) {
    assert(map.width > 0 && map.height > 0);
    constexpr double most_texels = 1 << 20;
    const double texels = double(map.width) * map.height;
    if (texels > most_texels) {
        const double shrink = std::sqrt(most_texels / texels);
        const auto smaller = [shrink](int size) { return std::max(1, static_cast<int>(size * shrink)); };
        return opaque_tile(averaged(map, smaller(map.width), smaller(map.height)),
                           std::max(0.25, tolerance * shrink));
    }

    MarchingSquares squares(map);
    Outlines outlines;
    const Outlines::Vertex_handle first = outlines.insert({0.5, 0.5});
    outlines.insert({map.width + 0.5, 0.5});
    outlines.insert({map.width + 0.5, map.height + 0.5});
    outlines.insert({0.5, map.height + 0.5});
    for (const Outline& outline : squares.outlines()) {
        if (outline.is_closed && area(outline.points) < tolerance * tolerance) continue;
        outlines.insert_constraint(outline.points.begin(), outline.points.end(), outline.is_closed);
    }
    simplification::simplify(outlines, DistinctCost(),
                             simplification::Stop_above_cost_threshold(tolerance * tolerance), false);

    for (auto face = outlines.all_faces_begin(); face != outlines.all_faces_end(); ++face)
        face->info() = Side::unknown;
    Outlines::Face_handle beside = first->face();
    while (outlines.is_infinite(beside)) beside = beside->neighbor(Outlines::ccw(beside->index(first)));
    tell_sides(outlines, beside, squares.value(0, 0) > half ? Side::opaque : Side::transparent);

    OpaqueTile tile;
    const Imath::V2d size(map.width, map.height);
    tile.corner = Imath::V2d(0.5, 0.5) / size;
    for (auto vertex = outlines.finite_vertices_begin(); vertex != outlines.finite_vertices_end(); ++vertex) {
        vertex->ID = tile.corners.size();
        tile.corners.push_back(Imath::V2d(vertex->point().x(), vertex->point().y()) / size);
    }
    for (auto face = outlines.finite_faces_begin(); face != outlines.finite_faces_end(); ++face) {
        if (face->info() != Side::opaque) continue;
        std::array<std::uint32_t, 3> triangle;
        for (int k = 0; k < 3; ++k)
            triangle[std::size_t(k)] = static_cast<std::uint32_t>(face->vertex(k)->ID);
        tile.triangles.push_back(triangle);
    }
    return tile;
}

}  // namespace haarfield
