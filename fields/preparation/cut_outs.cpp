#include "fields/preparation/cut_outs.h"

#include "fields/base/repeated_texels.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <optional>

namespace haarfield {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Place = Imath::V2d;  // in an image: x right, y down, 1 its width and height

std::array<Place, 3> places_of(const Mesh& mesh, const Triangle& triangle) {
    std::array<Place, 3> places;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2f& uv = mesh.uvs[triangle[k]];
        places[k] = {double(uv.x), 1 - double(uv.y)};
    }
    return places;
}

struct Box {
    Place lower, upper;

    explicit Box(const std::array<Place, 3>& of) : lower(of[0]), upper(of[0]) {
        for (const Place& place : of)
            for (int axis = 0; axis < 2; ++axis) {
                lower[axis] = std::min(lower[axis], place[axis]);
                upper[axis] = std::max(upper[axis], place[axis]);
            }
    }
};

/// Tests whether any texel that bilinear lookups inside a box read is less than half opaque.
bool has_hole(const OpacityMap& map, const Box& box) {
    return any_texel(box.lower, box.upper, map.width, map.height,
                     [&](std::size_t texel) { return map.opacity[texel] < 128; });
}

double cross(const Place& a, const Place& b) {
    return a.x * b.y - a.y * b.x;
}

/// A convex polygon in a triangle, in barycentric coordinates.
struct Piece {
    std::array<Vec3d, 8> corner;
    std::size_t corners = 0;

    /// The signed fraction of the triangle's area.
    double share() const {
        double sum = 0;
        for (std::size_t i = 0; i < corners; ++i) {
            const Vec3d &a = corner[i], &b = corner[(i + 1) % corners];
            sum += a.y * b.z - a.z * b.y;
        }
        return sum;
    }

    /// Clips the part where a weight is negative. On the cut, the weight is exactly 0, so that other pieces
    /// at the same edge of the triangle have the same cut.
    void keep_inside(int weight) {
        Piece kept;
        for (std::size_t i = 0; i < corners; ++i) {
            const Vec3d &a = corner[i], &b = corner[(i + 1) % corners];
            if (a[weight] >= 0) kept.corner[kept.corners++] = a;
            if ((a[weight] < 0) == (b[weight] < 0)) continue;
            const Vec3d &in = a[weight] < 0 ? b : a, &out = a[weight] < 0 ? a : b;
            Vec3d& cut = kept.corner[kept.corners++];
            cut = in + (out - in) * (in[weight] / (in[weight] - out[weight]));
            cut[weight] = 0;
        }
        *this = kept;
    }
};

/// Replaces triangles by pieces, up to a maximum number.
class Cutter {
public:
    Cutter(const Mesh& mesh, std::span<const OpacityMap> maps, std::span<const OpaqueTile> tiles,
           std::size_t most)
        : mesh_(mesh), maps_(maps), tiles_(tiles), most_(most) {
        for (const OpaqueTile& tile : tiles) {
            std::vector<Box>& boxes = boxes_.emplace_back();
            for (const Triangle& t : tile.triangles)
                boxes.emplace_back(std::array{tile.corners[t[0]], tile.corners[t[1]], tile.corners[t[2]]});
        }
    }

    /// Returns nothing if the maximum would be exceeded.
    std::optional<Mesh> cut(const std::vector<std::uint8_t>& is_cut_out) {
        result_.positions = mesh_.positions;
        result_.normals = mesh_.normals;
        result_.vertex_materials = mesh_.vertex_materials;
        result_.material_names = mesh_.material_names;
        for (std::size_t t = 0; t < is_cut_out.size(); ++t)
            if (!is_cut_out[t]) result_.triangles.push_back(mesh_.triangles[t]);
        most_ += result_.triangles.size();
        for (std::size_t t = 0; t < is_cut_out.size(); ++t)
            if (is_cut_out[t] && !add(mesh_.triangles[t])) return std::nullopt;
        return std::move(result_);
    }

private:
    /// Adds the pieces of a triangle. False if the maximum is exceeded; the result is then unusable.
    bool add(const Triangle& triangle) {
        const std::size_t material = mesh_.vertex_materials[triangle[0]];
        const OpaqueTile& tile = tiles_[material];
        const std::array<Place, 3> places = places_of(mesh_, triangle);
        const double twice_area = cross(places[1] - places[0], places[2] - places[0]);
        const Box box(places);
        const Place extent = box.upper - box.lower;
        if (std::abs(twice_area) <= 1e-9 * (extent.x * extent.x + extent.y * extent.y)) {
            // If the image is degenerate to a line, outlines cannot be mapped back to the surface.
            if (!has_hole(maps_[material], box)) result_.triangles.push_back(triangle);
            return result_.triangles.size() <= most_;
        }
        const auto first = [&](int axis) { return std::floor(box.lower[axis] - tile.corner[axis]); };
        const auto last = [&](int axis) { return std::floor(box.upper[axis] - tile.corner[axis]); };
        if ((last(0) - first(0) + 1) * (last(1) - first(1) + 1) * double(tile.triangles.size()) >
            64.0 * double(most_) + 1e6)
            return false;
        std::vector<Piece> pieces;
        double covered = 0;
        for (double row = first(1); row <= last(1); ++row)
            for (double column = first(0); column <= last(0); ++column) {
                const Place moved(column, row);
                const Place lower = box.lower - moved, upper = box.upper - moved;
                for (std::size_t t = 0; t < tile.triangles.size(); ++t) {
                    const Box& reach = boxes_[material][t];
                    if (reach.lower.x >= upper.x || reach.upper.x <= lower.x || reach.lower.y >= upper.y ||
                        reach.upper.y <= lower.y)
                        continue;
                    const auto& [a, b, c] = tile.triangles[t];
                    const Piece piece =
                        inside(places, twice_area,
                               {tile.corners[a] + moved, tile.corners[b] + moved, tile.corners[c] + moved});
                    if (piece.corners < 3) continue;
                    covered += std::abs(piece.share());
                    pieces.push_back(piece);
                    if (result_.triangles.size() + pieces.size() > most_ + 64) return false;
                }
            }
        constexpr double nearly = 1 - 1e-9;
        if (covered >= nearly)
            result_.triangles.push_back(triangle);
        else
            for (Piece& piece : pieces) add(triangle, piece);
        return result_.triangles.size() <= most_;
    }

    static Piece inside(const std::array<Place, 3>& places, double twice_area,
                        const std::array<Place, 3>& opaque) {
        Piece piece;
        for (const Place& place : opaque) {
            const Place from = place - places[0];
            const double y = cross(from, places[2] - places[0]) / twice_area,
                         z = cross(places[1] - places[0], from) / twice_area;
            piece.corner[piece.corners++] = {1 - y - z, y, z};
        }
        for (int weight = 0; weight < 3; ++weight) piece.keep_inside(weight);
        return piece;
    }

    void add(const Triangle& triangle, Piece& piece) {
        if (piece.share() < 0) std::reverse(piece.corner.begin(), piece.corner.begin() + long(piece.corners));
        std::array<Vec3d, 3> at;
        for (std::size_t k = 0; k < 3; ++k) at[k] = Vec3d(mesh_.positions[triangle[k]]);
        const Vec3f normal((at[1] - at[0]).cross(at[2] - at[0]).normalized());
        const auto first = static_cast<std::uint32_t>(result_.positions.size());
        for (std::size_t i = 0; i < piece.corners; ++i) {
            const Vec3d& w = piece.corner[i];
            result_.positions.push_back(Vec3f(at[0] * w.x + at[1] * w.y + at[2] * w.z));
            result_.normals.push_back(normal);
            result_.vertex_materials.push_back(mesh_.vertex_materials[triangle[0]]);
        }
        for (std::uint32_t i = 1; i + 1 < piece.corners; ++i) {
            const Triangle made{first, first + i, first + i + 1};
            const Vec3d a(result_.positions[made[0]]);
            const Vec3d twice =
                (Vec3d(result_.positions[made[1]]) - a).cross(Vec3d(result_.positions[made[2]]) - a);
            if (twice.length2() > 0) result_.triangles.push_back(made);
        }
    }

    const Mesh& mesh_;
    const std::span<const OpacityMap> maps_;
    const std::span<const OpaqueTile> tiles_;
    std::vector<std::vector<Box>> boxes_;  // indexed by tile and its triangles
    std::size_t most_;
    Mesh result_;
};

double mean_opacity(const OpacityMap& map) {
    if (map.opacity.empty()) return 1;
    return std::accumulate(map.opacity.begin(), map.opacity.end(), 0.0) / double(map.opacity.size()) / 255;
}

}  // namespace

std::vector<std::uint8_t> cut_out_triangles(const Mesh& mesh, std::span<const OpacityMap> maps) {
    assert(maps.empty() || maps.size() == mesh.material_names.size());
    std::vector<std::uint8_t> is_cut_out(mesh.triangles.size(), 0), has_holes;
    for (const OpacityMap& map : maps) has_holes.push_back(map.has_holes());
    if (maps.empty()) return is_cut_out;
    for (std::size_t t = 0; t < is_cut_out.size(); ++t) {
        const std::size_t material = mesh.vertex_materials[mesh.triangles[t][0]];
        if (has_holes[material])
            is_cut_out[t] = has_hole(maps[material], Box(places_of(mesh, mesh.triangles[t])));
    }
    return is_cut_out;
}

Mesh without_cut_outs(const Mesh& mesh, std::span<const OpacityMap> maps, std::size_t most_triangles) {
    constexpr double finest = 0.25;              // [texels]
    constexpr double coarsest = 1 / 16.0;        // fraction of the image
    constexpr std::size_t for_rough_shape = 16;  // triangles per cut triangle
    const std::vector<std::uint8_t> is_cut_out = cut_out_triangles(mesh, maps);
    const auto cut_triangles = static_cast<std::size_t>(std::ranges::count(is_cut_out, 1));
    std::vector<OpaqueTile> tiles(maps.size());
    for (double tolerance = finest;; tolerance *= 2) {
        bool is_last = true;
        for (std::size_t m = 0; m < maps.size(); ++m) {
            if (!maps[m].has_holes()) continue;
            const double most = std::max(finest, coarsest * std::min(maps[m].width, maps[m].height));
            if (tolerance <= 2 * most) tiles[m] = opaque_tile(maps[m], std::min(tolerance, most));
            is_last = is_last && tolerance >= most;
        }
        const std::size_t most =
            is_last ? std::max(most_triangles, for_rough_shape * cut_triangles) : most_triangles;
        if (std::optional<Mesh> cut = Cutter(mesh, maps, tiles, most).cut(is_cut_out)) return std::move(*cut);
        if (is_last) break;
    }
    std::vector<bool> is_there;
    for (const OpacityMap& map : maps) is_there.push_back(mean_opacity(map) >= 0.5);
    Mesh whole = mesh;
    whole.uvs.clear();
    whole.colours.clear();
    whole.original_vertices.clear();
    whole.triangles.clear();
    for (const bool cut_out : {false, true})
        for (std::size_t t = 0; t < is_cut_out.size(); ++t)
            if (bool(is_cut_out[t]) == cut_out &&
                (!cut_out || is_there[mesh.vertex_materials[mesh.triangles[t][0]]]))
                whole.triangles.push_back(mesh.triangles[t]);
    return whole;
}

}  // namespace haarfield
