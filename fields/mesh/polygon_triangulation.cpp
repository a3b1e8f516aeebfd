#include "fields/mesh/polygon_triangulation.h"

#include <Imath/ImathVec.h>
#include <algorithm>
#include <cassert>
#include <optional>

namespace haarfield {

namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Vec2d = Imath::V2d;

double turn(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
    return (b - a).cross(c - a);
}

/// Projects a polygon along the axis that preserves most of its area. The result is counter-clockwise.
std::vector<Vec2d> flattened(const std::vector<Vec3f>& polygon) {
    Vec3d normal(0, 0, 0);  // Newell's
    for (std::size_t i = 0; i < polygon.size(); ++i)
        normal += (Vec3d(polygon[i]) - Vec3d(polygon[0]))
                      .cross(Vec3d(polygon[(i + 1) % polygon.size()]) - Vec3d(polygon[0]));
    int axis = 0;
    for (int other = 1; other < 3; ++other)
        if (std::abs(normal[other]) > std::abs(normal[axis])) axis = other;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    std::vector<Vec2d> flat;
    for (const Vec3f& p : polygon) flat.emplace_back(p[u], normal[axis] < 0 ? -p[v] : p[v]);
    return flat;
}

}  // namespace

std::vector<Triangle> triangulated(const std::vector<Vec3f>& polygon) {
    assert(polygon.size() >= 3);
    constexpr std::size_t largest = 2000;
    std::vector<Triangle> triangles;
    if (polygon.size() > largest) {
        for (std::uint32_t i = 2; i < polygon.size(); ++i) triangles.push_back({0, i - 1, i});
        return triangles;
    }
    const std::vector<Vec2d> flat = flattened(polygon);
    std::vector<std::uint32_t> left(polygon.size());
    for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;

    const auto cut = [&](std::size_t i) {
        const std::size_t n = left.size();
        return Triangle{left[(i + n - 1) % n], left[i], left[(i + 1) % n]};
    };
    const auto is_ear = [&](const Triangle& t) {
        const Vec2d &a = flat[t[0]], &b = flat[t[1]], &c = flat[t[2]];
        if (!(turn(a, b, c) > 0)) return false;
        for (std::uint32_t other : left) {
            const Vec2d& p = flat[other];
            if (p == a || p == b || p == c) continue;
            if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
        }
        return true;
    };
    // cutting an ear changes the status of a corner only for its neighbours
    std::vector<std::optional<bool>> ear(polygon.size());
    while (left.size() > 3) {
        std::size_t best = 0;
        double best_length = INFINITY;
        for (std::size_t i = 0; i < left.size(); ++i) {
            const Triangle t = cut(i);
            const double length = (flat[t[0]] - flat[t[2]]).length2();
            if (!(length < best_length)) continue;
            if (!ear[t[1]]) ear[t[1]] = is_ear(t);
            if (!*ear[t[1]]) continue;
            best = i;
            best_length = length;
        }
        const Triangle t = cut(best);
        triangles.push_back(t);
        ear[t[0]].reset();
        ear[t[2]].reset();
        if (best_length == INFINITY) std::fill(ear.begin(), ear.end(), std::nullopt);
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(best));
        // a cut can also make an ear of a blocked corner, so corners that failed are tested again
        for (std::uint32_t i : left)
            if (ear[i] && !*ear[i]) ear[i].reset();
    }
    triangles.push_back({left[0], left[1], left[2]});
    return triangles;
}

}  // namespace haarfield
