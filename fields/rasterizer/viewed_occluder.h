#pragma once
/// An occluder relative to a view point: the data that both paths of the visibility rasterizer share.

#include <cstdint>

#include "fields/occluder/occluder.h"

namespace haarfield {

/// An occluder relative to a view point.
struct ViewedOccluder {
    Vec3f view_point;
    Vec3f from_centre;     ///< The view point relative to OccluderPlanes::centre. [m]
    float thin = 0;        ///< A triangle appears thin if its OccluderPlanes measure is at most this. [m^2]
    bool horizon = false;  ///< True if there is a horizon.
    Vec3f up{0.0f};        ///< The unit normal of the horizon.
    float lowest = -1;     ///< A vertex is below the horizon up to this height above the view point. [m]
};

/// Prepares an occluder for a view point. horizon: as in OccluderView.
ViewedOccluder look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon);

/// Returns how a triangle contributes to the contour: 1 front-facing, -1 back-facing, 0 not at all. It is 0
/// for triangles that are exactly edge-on, without area, one-sided and back-facing, or below the horizon. It
/// is also 0 for triangles left to the span rasterizer: OccluderEdges::loose, or so thin that rounding may
/// flip them.
int facing(const Occluder& occluder, const ViewedOccluder& viewed, std::uint32_t triangle);

/// Returns x, y, z, 0 of both ends of an edge.
inline const float (&edge_ends(const OccluderEdges& edges, std::uint32_t number))[2][4] {
    return edges.clusters[number / OccluderEdges::cluster_size].ends[number % OccluderEdges::cluster_size];
}

/// Replaces a coordinate difference of 0, so that no vertex lies on a plane x = 0, y = 0 or z = 0, and all
/// code agrees on its side.
inline constexpr float almost_zero = -1e-30f;
/// Returns a coordinate relative to the view point, never 0.
inline float from_view_point(float coordinate, float view_point) {
    const float difference = coordinate - view_point;
    return difference == 0 ? almost_zero : difference;
}

}  // namespace haarfield
