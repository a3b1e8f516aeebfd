#pragma once
/// Occluders of few triangles, such as floors and walls, evaluated exactly from any point.

#include "fields/occluder/occluder.h"

#include <span>

namespace haarfield {

/// A flat, convex polygon that blocks light. Corners are counter-clockwise about the normal. [m]
struct ConvexPolygon {
    std::vector<Vec3f> corners;
    Vec3f normal;
    bool two_sided = true;  ///< False: blocks only the view of points in front of it.
};

/// Returns the triangles of an occluder, merged where neighbours lie in one plane and their union is convex:
/// a rectangle becomes one polygon for any triangulation.
///
/// cost  cubic in the number of triangles; intended for up to 64.
std::vector<ConvexPolygon> convex_polygons(const Occluder& occluder);

/// Rotates polygons about the origin.
std::vector<ConvexPolygon> turned_polygons(std::vector<ConvexPolygon> polygons, const Rotation& rotation);

/// The directions that convex polygons block from a point, as cones. Each cone is the intersection of half
/// spaces through the point.
struct BlockedCones {
    std::span<const Vec3f> sides;        ///< Unit normals that point inwards, by cone.
    std::span<const std::uint32_t> end;  ///< End of each cone's sides.
};

/// Cones with their memory.
struct BlockedConeList {
    std::vector<Vec3f> sides;
    std::vector<std::uint32_t> end;

    operator BlockedCones() const { return {sides, end}; }  ///< A view for the walk.
    /// Removes all cones; keeps the memory.
    void clear() {
        sides.clear();
        end.clear();
    }
};

/// Adds the cones of the polygons that block light at a point in the polygons' frame.
void add_cones(std::span<const ConvexPolygon> polygons, const Vec3f& point, BlockedConeList& cones);

}  // namespace haarfield
