#include "shading/walk/blocked_cones.h"

#include <algorithm>
#include <optional>

namespace haarfield {
namespace {

constexpr float flat = 1e-5f;  ///< Tolerance of unit vectors within a plane or a line.

/// Removes corners on straight lines. Returns true if the remaining polygon turns left everywhere about the
/// normal.
bool make_convex(std::vector<Vec3f>& corners, const Vec3f& normal) {
    for (std::size_t i = 0; i < corners.size() && corners.size() > 2;) {
        const std::size_t count = corners.size();
        const Vec3f before = (corners[i] - corners[(i + count - 1) % count]).normalized(),
                    after = (corners[(i + 1) % count] - corners[i]).normalized();
        const float turn = before.cross(after).dot(normal);
        if (turn < -flat || (turn < flat && before.dot(after) < 0)) return false;
        if (turn < flat)
            corners.erase(corners.begin() + std::ptrdiff_t(i));
        else
            ++i;
    }
    return corners.size() > 2;
}

/// Returns the union of two polygons that share an edge, if it is flat and convex.
std::optional<ConvexPolygon> merged(const ConvexPolygon& a, const ConvexPolygon& b) {
    if (a.two_sided != b.two_sided || a.normal.dot(b.normal) < 1 - flat) return std::nullopt;
    const std::size_t m = a.corners.size(), n = b.corners.size();
    for (std::size_t i = 0; i < m; ++i)
        for (std::size_t k = 0; k < n; ++k) {
            if (a.corners[i] != b.corners[(k + 1) % n] || a.corners[(i + 1) % m] != b.corners[k]) continue;
            ConvexPolygon both{{}, a.normal, a.two_sided};
            for (std::size_t c = 0; c < m; ++c) both.corners.push_back(a.corners[(i + 1 + c) % m]);
            for (std::size_t c = 2; c < n; ++c) both.corners.push_back(b.corners[(k + c) % n]);
            if (make_convex(both.corners, both.normal)) return both;
        }
    return std::nullopt;
}

/// Merges one pair of polygons. Returns false if no pair can be merged.
bool merge_a_pair(std::vector<ConvexPolygon>& polygons) {
    for (std::size_t i = 0; i < polygons.size(); ++i)
        for (std::size_t k = i + 1; k < polygons.size(); ++k)
            if (auto both = merged(polygons[i], polygons[k])) {
                polygons[i] = std::move(*both);
                polygons.erase(polygons.begin() + std::ptrdiff_t(k));
                return true;
            }
    return false;
}

}  // namespace

std::vector<ConvexPolygon> convex_polygons(const Occluder& occluder) {
    std::vector<ConvexPolygon> polygons;
    for (std::size_t t = 0; t < occluder.triangles().size(); ++t) {
        ConvexPolygon polygon;
        for (const std::uint32_t vertex : occluder.triangles()[t])
            polygon.corners.push_back(occluder.positions()[vertex]);
        const Vec3f across =
            (polygon.corners[1] - polygon.corners[0]).cross(polygon.corners[2] - polygon.corners[0]);
        if (!(across.length() > 0)) continue;  // No area.
        polygon.normal = across.normalized();
        polygon.two_sided = t >= occluder.one_sided();
        polygons.push_back(std::move(polygon));
    }
    while (merge_a_pair(polygons)) {
    }
    return polygons;
}

std::vector<ConvexPolygon> turned_polygons(std::vector<ConvexPolygon> polygons, const Rotation& rotation) {
    for (ConvexPolygon& polygon : polygons) {
        for (Vec3f& corner : polygon.corners) corner = rotation(corner);
        polygon.normal = rotation(polygon.normal);
    }
    return polygons;
}

void add_cones(std::span<const ConvexPolygon> polygons, const Vec3f& point, BlockedConeList& cones) {
    for (const ConvexPolygon& polygon : polygons) {
        const float height = (point - polygon.corners[0]).dot(polygon.normal);
        if (height == 0 || (height < 0 && !polygon.two_sided)) continue;
        // Viewed from its front, the polygon's corners run clockwise about the view direction.
        const float inwards = height > 0 ? -1.0f : 1.0f;
        const std::size_t count = polygon.corners.size();
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3f side = (polygon.corners[i] - point).cross(polygon.corners[(i + 1) % count] - point);
            cones.sides.push_back(side.normalized() * inwards);
        }
        cones.end.push_back(static_cast<std::uint32_t>(cones.sides.size()));
    }
}

}  // namespace haarfield
