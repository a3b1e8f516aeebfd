#include "fields/mesh/closed_pieces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fields/mesh/edge_uses.h"

namespace haarfield {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
constexpr std::size_t most_rooms = 64;

/// Returns the indices of the largest pieces that pass a test.
template <class Test>
std::vector<std::size_t> largest_pieces(std::span<const ClosedPiece> pieces, const Test& passes) {
    std::vector<std::size_t> numbers;
    for (std::size_t i = 0; i < pieces.size(); ++i)
        if (passes(pieces[i])) numbers.push_back(i);
    std::stable_sort(numbers.begin(), numbers.end(), [&](std::size_t a, std::size_t b) {
        return pieces[a].bounds.radius() > pieces[b].bounds.radius();
    });
    numbers.resize(std::min(numbers.size(), most_rooms));
    return numbers;
}

bool encloses(std::span<const Vec3f> positions, const ClosedPiece& piece, const Vec3f& point) {
    return contains(piece.bounds, {point, point}) &&
           winding_number(positions, piece.triangles, Vec3d(point)) > 0.5;
}

bool encloses(std::span<const Vec3f> positions, const ClosedPiece& outer, const ClosedPiece& inner) {
    return &outer != &inner && contains(outer.bounds, inner.bounds) &&
           encloses(positions, outer, inner.bounds.centre());
}

/// Tests whether the centre of the box is in front of all triangles, after they are flipped inwards.
bool is_visible_from_middle(std::span<const Vec3f> positions, const ClosedPiece& piece) {
    const Vec3d middle(piece.bounds.centre());
    return std::ranges::all_of(piece.triangles, [&](const Triangle& t) {
        const Vec3d a(positions[t[0]]), b(positions[t[1]]), c(positions[t[2]]);
        return (b - a).cross(c - a).dot(a - middle) > 0;
    });
}

/// Tests whether each triangle is a wall parallel to `up`, or part of a level floor or ceiling in the lowest
/// or highest plane.
bool is_prism(std::span<const Vec3f> positions, const ClosedPiece& piece, const Vec3d& up) {
    constexpr double angle = 0.01, level = 0.01;  // sine; of the height
    double lowest = INFINITY, highest = -INFINITY;
    for (const Triangle& t : piece.triangles)
        for (const std::uint32_t corner : t) {
            lowest = std::min(lowest, up.dot(Vec3d(positions[corner])));
            highest = std::max(highest, up.dot(Vec3d(positions[corner])));
        }
    const double tolerance = level * (highest - lowest);
    return std::ranges::all_of(piece.triangles, [&](const Triangle& t) {
        const Vec3d a(positions[t[0]]), b(positions[t[1]]), c(positions[t[2]]);
        const Vec3d normal = (b - a).cross(c - a);
        if (std::abs(normal.dot(up)) <= angle * normal.length()) return true;
        const std::array<double, 3> heights{up.dot(a), up.dot(b), up.dot(c)};
        return std::ranges::all_of(heights, [&](double h) { return h <= lowest + tolerance; }) ||
               std::ranges::all_of(heights, [&](double h) { return h >= highest - tolerance; });
    });
}

/// Tests whether a box is as large as another one that contains it, within a hundredth.
bool fills(const Bounds& inner, const Bounds& outer) {
    const Vec3f small = inner.upper - inner.lower, large = outer.upper - outer.lower;
    return small.x >= 0.99f * large.x && small.y >= 0.99f * large.y && small.z >= 0.99f * large.z;
}

/// Pieces of triangles connected by shared edges, and whether they are open.
struct EdgePieces {
    Pieces pieces;
    std::vector<std::uint8_t> is_open;  ///< Indexed by root.
};

EdgePieces edge_pieces(const std::vector<Triangle>& triangles) {
    EdgePieces result{Pieces(triangles.size()), std::vector<std::uint8_t>(triangles.size(), 0)};
    std::vector<std::uint8_t> open_at(triangles.size(), 0);
    const std::vector<EdgeUse> uses = sorted_edge_uses(triangles);
    for (std::size_t first = 0; first < uses.size();) {
        std::size_t last = first;
        while (last < uses.size() && same_edge(uses[first], uses[last])) ++last;
        const bool closed = last - first == 2 && uses[first].forward != uses[first + 1].forward;
        for (std::size_t i = first; i < last; ++i) {
            result.pieces.join(uses[i].triangle, uses[first].triangle);
            if (!closed) open_at[uses[i].triangle] = 1;
        }
        first = last;
    }
    for (std::uint32_t t = 0; t < triangles.size(); ++t) result.is_open[result.pieces.root(t)] |= open_at[t];
    return result;
}

}  // namespace

bool contains(const Bounds& outer, const Bounds& inner) {
    for (int axis = 0; axis < 3; ++axis)
        if (!(outer.lower[axis] <= inner.lower[axis] && outer.upper[axis] >= inner.upper[axis])) return false;
    return true;
}

double winding_number(std::span<const Vec3f> positions, std::span<const Triangle> triangles,
                      const Vec3d& point) {
    double angle = 0;
    for (const Triangle& t : triangles) {
        const Vec3d a = Vec3d(positions[t[0]]) - point, b = Vec3d(positions[t[1]]) - point,
                    c = Vec3d(positions[t[2]]) - point;
        const double la = a.length(), lb = b.length(), lc = c.length();
        angle += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return angle / (2 * std::numbers::pi);
}

std::vector<std::uint8_t> inward_pieces(std::span<const Vec3f> positions,
                                        std::span<const ClosedPiece> pieces) {
    std::vector<std::uint8_t> inwards(pieces.size(), 0);
    for (const std::size_t i : largest_pieces(pieces, [](const ClosedPiece& p) { return p.faces_inwards; }))
        inwards[i] = 1;
    if (std::ranges::find(inwards, 1) != inwards.end()) return inwards;
    for (const std::size_t i : largest_pieces(pieces, [](const ClosedPiece&) { return true; }))
        inwards[i] = std::ranges::none_of(
            pieces, [&](const ClosedPiece& other) { return encloses(positions, other, pieces[i]); });
    return inwards;
}

std::vector<std::size_t> rooms(std::span<const Vec3f> positions, std::span<const ClosedPiece> pieces,
                               std::span<const Vec3f> contents, const Vec3d& up) {
    const Bounds all = bounds_of(positions);
    const auto is_room = [&](const ClosedPiece& room) {
        if (fills(room.bounds, all) &&
            (is_visible_from_middle(positions, room) || is_prism(positions, room, up)))
            return true;
        return std::ranges::any_of(contents,
                                   [&](const Vec3f& point) { return encloses(positions, room, point); }) ||
               std::ranges::any_of(pieces, [&](const ClosedPiece& other) {
                   return encloses(positions, room, other) ||
                          (!other.faces_inwards && encloses(positions, other, room));
               });
    };
    std::vector<std::size_t> found =
        largest_pieces(pieces, [](const ClosedPiece& p) { return p.faces_inwards; });
    std::erase_if(found, [&](std::size_t i) { return !is_room(pieces[i]); });
    return found;
}

std::vector<PieceKind> piece_kinds(std::span<const Vec3f> positions, const std::vector<Triangle>& triangles) {
    EdgePieces edges = edge_pieces(triangles);
    const Vec3d centre(bounds_of(positions).centre());
    std::vector<double> volume(triangles.size(), 0);  // by root
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const Vec3d a = Vec3d(positions[triangles[t][0]]) - centre,
                    b = Vec3d(positions[triangles[t][1]]) - centre,
                    c = Vec3d(positions[triangles[t][2]]) - centre;
        volume[edges.pieces.root(t)] += a.dot(b.cross(c));
    }
    std::vector<PieceKind> of_root(triangles.size(), PieceKind::open), kinds(triangles.size());
    bool any_inwards = false;
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        if (const std::uint32_t root = edges.pieces.root(t); !edges.is_open[root]) {
            of_root[root] = volume[root] > 0 ? PieceKind::solid : PieceKind::room;
            any_inwards |= volume[root] <= 0;
        }
    if (any_inwards) {
        std::vector<std::uint32_t> roots, number_of_root(triangles.size(), UINT32_MAX);
        std::vector<ClosedPiece> pieces;
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            const std::uint32_t root = edges.pieces.root(t);
            if (edges.is_open[root]) continue;
            if (number_of_root[root] == UINT32_MAX) {
                number_of_root[root] = static_cast<std::uint32_t>(roots.size());
                roots.push_back(root);
                pieces.emplace_back().faces_inwards = of_root[root] == PieceKind::room;
            }
            ClosedPiece& piece = pieces[number_of_root[root]];
            piece.triangles.push_back(triangles[t]);
            for (const std::uint32_t corner : triangles[t]) piece.bounds.add(positions[corner]);
        }
        for (const std::size_t i :
             largest_pieces(pieces, [](const ClosedPiece& p) { return p.faces_inwards; }))
            if (std::ranges::any_of(pieces, [&](const ClosedPiece& other) {
                    return !other.faces_inwards && encloses(positions, other, pieces[i]);
                }))
                of_root[roots[i]] = PieceKind::solid;
    }
    for (std::uint32_t t = 0; t < triangles.size(); ++t) kinds[t] = of_root[edges.pieces.root(t)];
    return kinds;
}

}  // namespace haarfield
