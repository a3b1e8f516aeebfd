#include "bridge/povray_import/object_silhouettes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "bridge/povray_import/object_lattice.h"
#include "bridge/povray_import/texel_camera.h"
#include "bridge/povray_import/triangle_text.h"

namespace haarfield {
namespace {

constexpr int pixels_per_cell = 4;
constexpr double most_pixels = 4e6;
constexpr double gap = 1;  // Between an object's box and the rays' starts and ends. [cells]

using PixelPoint = Imath::Vec2<double>;  ///< Pixel (x, y) covers [x, x + 1) x [y, y + 1).

/// A pixel image of points that are set, with one byte each.
class Mask {
public:
    Mask(int columns, int rows)
        : Mask(columns, rows, std::vector<std::uint8_t>(std::size_t(columns) * std::size_t(rows))) {}
    Mask(int columns, int rows, std::vector<std::uint8_t> set)
        : columns_(columns), rows_(rows), set_(std::move(set)) {}

    /// Sets the pixels whose centres are inside a triangle, and those of its edges.
    void add(const std::array<PixelPoint, 3>& corners) {
        for (std::size_t k = 0; k < 3; ++k) add_edge(corners[k], corners[(k + 1) % 3]);
        const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
        const int first = std::max(0, int(std::ceil(low - 0.5))),
                  last = std::min(rows_ - 1, int(std::floor(high - 0.5)));
        for (int row = first; row <= last; ++row) {
            double from = INFINITY, to = -INFINITY;
            for (std::size_t k = 0; k < 3; ++k) {
                const PixelPoint &a = corners[k], &b = corners[(k + 1) % 3];
                const double t = (row + 0.5 - a.y) / (b.y - a.y);
                if (!(t >= 0 && t <= 1)) continue;
                from = std::min(from, a.x + t * (b.x - a.x));
                to = std::max(to, a.x + t * (b.x - a.x));
            }
            for (int column = std::max(0, int(std::ceil(from - 0.5)));
                 column <= std::min(columns_ - 1, int(std::floor(to - 0.5))); ++column)
                set(column, row);
        }
    }

    /// Returns the pixels within a distance along both axes.
    std::vector<std::uint8_t> widened(int distance) const {
        std::vector<std::uint8_t> along_rows(set_.size()), wide(set_.size());
        spread(set_, along_rows, columns_, rows_, 1, columns_, distance);
        spread(along_rows, wide, rows_, columns_, columns_, 1, distance);
        return wide;
    }

    const std::vector<std::uint8_t>& pixels() const { return set_; }

private:
    void set(int column, int row) {
        set_[std::size_t(row) * std::size_t(columns_) + std::size_t(column)] = 1;
    }

    void add_edge(const PixelPoint& from, const PixelPoint& to) {
        const PixelPoint along = to - from;
        const int steps = std::max(1, int(std::ceil(2 * std::max(std::abs(along.x), std::abs(along.y)))));
        for (int step = 0; step <= steps; ++step) {
            const PixelPoint at = from + along * (double(step) / steps);
            if (at.x >= 0 && at.y >= 0 && at.x < columns_ && at.y < rows_) set(int(at.x), int(at.y));
        }
    }

    /// Spreads the pixels of `count` lines of a length; `step` and `line` are the distances in memory.
    static void spread(const std::vector<std::uint8_t>& from, std::vector<std::uint8_t>& to, int length,
                       int count, int step, int line, int distance) {
        for (int l = 0; l < count; ++l)
            for (int at = 0; at < length; ++at) {
                const std::size_t start = std::size_t(l) * std::size_t(line);
                if (!from[start + std::size_t(at) * std::size_t(step)]) continue;
                for (int near = std::max(0, at - distance); near <= std::min(length - 1, at + distance);
                     ++near)
                    to[start + std::size_t(near) * std::size_t(step)] = 1;
            }
    }

    int columns_, rows_;
    std::vector<std::uint8_t> set_;
};

/// A rectangle of the picture.
struct Place {
    int left = 0, top = 0;
};

/// Places rectangles in rows of a width. Returns the height of all.
int pack(std::span<const std::array<int, 2>> sizes, int width, std::vector<Place>& places) {
    int left = 0, top = 0, height = 0;
    for (const auto& [columns, rows] : sizes) {
        if (left > 0 && left + columns > width) {
            top += height;
            left = height = 0;
        }
        places.push_back({left, top});
        left += columns;
        height = std::max(height, rows);
    }
    return top + height;
}

/// Returns the requests with the most cells, whose objects are large in the picture, as far as the pixels
/// suffice.
std::vector<GridRequest> chosen_requests(std::span<const GridRequest> requests) {
    std::vector<GridRequest> chosen;
    std::ranges::copy_if(requests, std::back_inserter(chosen), std::logical_not(), &GridRequest::is_cut);
    std::ranges::stable_sort(chosen, std::ranges::greater(), &GridRequest::cells);
    double pixels = 0;
    const auto is_too_much = [&](const GridRequest& request) {
        const Vec3d sides =
            (request.size * grid_frame(request).scale + Vec3d(2 * gap)) * double(pixels_per_cell);
        pixels += sides.x * sides.y + sides.y * sides.z + sides.z * sides.x;
        return pixels > most_pixels;
    };
    chosen.erase(std::ranges::find_if(chosen, is_too_much), chosen.end());
    std::ranges::sort(chosen, {}, &GridRequest::object);
    return chosen;
}

}  // namespace

void ObjectSilhouettes::add_tiles(const GridRequest& request) {
    const GridFrame frame = grid_frame(request);
    const Vec3d half = request.size / 2 + Vec3d(gap) / frame.scale;
    for (int axis = 0; axis < 3; ++axis) {
        Tile& tile = tiles_.emplace_back();
        tile.object = request.object;
        tile.axis = axis;
        tile.lower = request.centre - half;
        tile.pixels = frame.scale * double(pixels_per_cell);
        const Vec3d sides = half * 2 * tile.pixels;
        tile.columns = int(std::ceil(sides[(axis + 1) % 3]));
        tile.rows = int(std::ceil(sides[(axis + 2) % 3]));
    }
}

Result<ObjectSilhouettes> ObjectSilhouettes::create(const SceneQueries& queries,
                                                    std::span<const GridRequest> requests, double seconds,
                                                    const Progress& progress) {
    ObjectSilhouettes result;
    const std::vector<GridRequest> chosen = chosen_requests(requests);
    if (chosen.empty()) return result;
    for (const GridRequest& request : chosen) result.add_tiles(request);
    std::vector<std::array<int, 2>> sizes;
    int width = 1024;
    for (const Tile& tile : result.tiles_) {
        sizes.push_back({tile.columns, tile.rows});
        width = std::max(width, tile.columns);
    }
    std::vector<Place> places;
    const int height = pack(sizes, width, places);

    // Each silhouette's rays start at a rectangle in front of the object, and end at a screen behind it.
    const ObjectLattice lattice(chosen);
    TexelCamera camera(width, height);
    TriangleText screens;
    for (std::size_t t = 0; t < result.tiles_.size(); ++t) {
        const Tile& tile = result.tiles_[t];
        const std::size_t s = t / 3, first = camera.vertices();
        const GridFrame& frame = lattice.frame(s);
        const int across = (tile.axis + 1) % 3, down = (tile.axis + 2) % 3;
        const double depth = 2 * (frame.shift - frame.local_point(tile.lower))[tile.axis];
        std::array<Vec3d, 4> screen;
        for (std::size_t k = 0; k < 4; ++k) {
            const int x = k == 1 || k == 2 ? tile.columns : 0, y = k >= 2 ? tile.rows : 0;
            Vec3d at = tile.lower;
            at[across] += x / tile.pixels[across];
            at[down] += y / tile.pixels[down];
            Vec3d front = screen[k] = lattice.placed(s, frame.local_point(at));
            front[tile.axis] += depth;
            camera.add_vertex(front, double(places[t].left + x) / width,
                              1 - double(places[t].top + y) / height);
        }
        camera.add_triangle(first, first + 1, first + 2);
        camera.add_triangle(first, first + 2, first + 3);
        screens.add({screen[0], screen[1], screen[2]});
        screens.add({screen[0], screen[2], screen[3]});
    }
    // Transparent parts are black, since their rays end.
    SceneQuery query = lattice.query(
        width, height,
        fmt::format("{}global_settings{{max_trace_level 1}}\n"
                    "{} pigment{{{}}} finish{{ambient 0 diffuse 0 emission HF_E}} no_shadow}}\n",
                    camera.text(0), screens.mesh2(), no_surface_colour()));
    query.pigments = true;
    query.in_numbers = false;
    query.seconds = seconds;
    HF_TRY(const SceneAnswer answer, queries.answer(query, progress));
    const std::vector<std::uint8_t> met = pixels_on_surfaces(queries.gamma(), answer.pixels);
    for (std::size_t t = 0; t < result.tiles_.size(); ++t) {
        Tile& tile = result.tiles_[t];
        for (int y = 0; y < tile.rows; ++y) {
            const auto row = met.begin() + std::ptrdiff_t(places[t].top + y) * width + places[t].left;
            tile.met.insert(tile.met.end(), row, row + tile.columns);
        }
    }
    return result;
}

std::size_t ObjectSilhouettes::wrong_pixels(const ObjectSurface& surface) const {
    std::size_t wrong = 0;
    for (const Tile& tile : tiles_) {
        if (tile.object != surface.object) continue;
        const int across = (tile.axis + 1) % 3, down = (tile.axis + 2) % 3;
        Mask mask(tile.columns, tile.rows);
        for (const auto& triangle : surface.triangles) {
            std::array<PixelPoint, 3> corners;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3d at = (Vec3d(surface.positions[triangle[k]]) - tile.lower) * tile.pixels;
                corners[k] = {at[across], at[down]};
            }
            mask.add(corners);
        }
        const std::vector<std::uint8_t> near_surface = mask.widened(1),
                                        near_object = Mask(tile.columns, tile.rows, tile.met).widened(1);
        for (std::size_t i = 0; i < tile.met.size(); ++i)
            wrong += (tile.met[i] && !near_surface[i]) || (mask.pixels()[i] && !near_object[i]);
    }
    return wrong;
}

}  // namespace haarfield
