#pragma once
/// Occluders of few triangles, such as floors and walls, seen exactly from any point.

#include "fields/occluder/occluder.h"

#include <span>

namespace haarfield {

/// A flat, convex polygon that blocks light. Corners counter-clockwise about the normal. [m]
struct ConvexPolygon {
    std::vector<Vec3f> corners;
    Vec3f normal;
    bool two_sided = true;  ///< Else it blocks only where it is seen from the front.
};

/// The triangles of an occluder, merged where two neighbours lie in one plane and are convex together: a
/// rectangle is one polygon however it was cut.
///
/// cost  cubic in the triangles; meant for some 64.
std::vector<ConvexPolygon> convex_polygons(const Occluder& occluder);

/// The same, turned about the origin.
std::vector<ConvexPolygon> turned_polygons(std::vector<ConvexPolygon> polygons, const Rotation& rotation);

/// What convex polygons cover, seen from a point: cones, each the intersection of half spaces through the
/// point.
struct BlockedCones {
    std::span<const Vec3f> sides;        ///< Unit normals, inwards; cone by cone.
    std::span<const std::uint32_t> end;  ///< Of each cone's sides.
};

/// The same with its memory.
struct BlockedConeList {
    std::vector<Vec3f> sides;
    std::vector<std::uint32_t> end;

    operator BlockedCones() const { return {sides, end}; }  ///< As the walk takes them.
    /// Removes all cones; memory stays.
    void clear() {
        sides.clear();
        end.clear();
    }
};

/// Adds the cones of the polygons that block the view from a point of their own frame.
void add_cones(std::span<const ConvexPolygon> polygons, const Vec3f& point, BlockedConeList& cones);

}  // namespace haarfield
