#pragma once
/// An occluder as it is seen from a view point: what both paths of the visibility rasterizer agree about.

#include <cstdint>

#include "fields/occluder/occluder.h"

namespace haarfield {

/// An occluder as it is seen from one place.
struct ViewedOccluder {
    Vec3f view_point;
    Vec3f from_centre;     ///< The view point from OccluderPlanes::centre. [m]
    float thin = 0;        ///< A triangle looks thin whose OccluderPlanes measure is at most that. [m^2]
    bool horizon = false;  ///< Whether there is one. If so,
    Vec3f up{0.0f};        ///< its unit normal;
    float lowest = -1;     ///< and a vertex is below if it lies no higher than that over the view point. [m]
};

/// horizon  as VisibilityRasterizer's.
ViewedOccluder look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon);

/// Whether and how a triangle counts for the contour: 1 seen from the front, -1 from behind. 0 does not:
/// those without area or seen exactly edge-on, one-sided ones from behind, those below the horizon, and those
/// that are left to the span rasterizer, as OccluderEdges::loose or because they look so thin that rounding
/// may turn them over.
int facing(const Occluder& occluder, const ViewedOccluder& viewed, std::uint32_t triangle);

/// x, y, z, 0 of the ends of an edge.
inline const float (&edge_ends(const OccluderEdges& edges, std::uint32_t number))[2][4] {
    return edges.clusters[number / OccluderEdges::cluster_size].ends[number % OccluderEdges::cluster_size];
}

/// A coordinate from the view point. Never 0, so that no vertex lies on a plane x = 0, y = 0 or z = 0, and
/// each is on one side for all who ask.
inline constexpr float almost_zero = -1e-30f;
/// A coordinate in the frame whose origin is the view point.
inline float from_view_point(float coordinate, float view_point) {
    const float difference = coordinate - view_point;
    return difference == 0 ? almost_zero : difference;
}

}  // namespace haarfield
