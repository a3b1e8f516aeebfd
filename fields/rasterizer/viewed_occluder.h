#pragma once
/// An occluder relative to a view point: the data that both paths of the visibility rasterizer share.

#include <array>
#include <cstdint>

#include "fields/occluder/occluder.h"

namespace haarfield {

/// An occluder relative to a view point. Vertices are rotated into the frame of the cubemap; planes and boxes
/// are evaluated in the occluder's frame.
struct ViewedOccluder {
    Vec3f view_point;        ///< In the occluder's frame.
    Vec3f from_centre;       ///< The view point relative to OccluderPlanes::centre. [m]
    float thin = 0;          ///< A triangle appears thin if its OccluderPlanes measure is at most this. [m^2]
    bool horizon = false;    ///< True if there is a horizon.
    Vec3f up{0.0f};          ///< The unit normal of the horizon, in the cubemap's frame.
    Vec3f object_up{0.0f};   ///< The same normal, in the occluder's frame.
    float lowest = -1;       ///< A vertex is below the horizon up to this height above the view point. [m]
    bool is_turned = false;  ///< True if the frames differ by a rotation.
    std::array<Vec3f, 3> axes{};  ///< The cubemap's axes in the occluder's frame, if turned.

    /// Returns a vertex relative to the view point, in the cubemap's frame. No coordinate is 0. The result is
    /// bit-identical to that of viewed_vertices.
    Vec3f viewed(const Vec3f& position) const;
};

/// Prepares an occluder for a view point. horizon, turn: as in OccluderView.
ViewedOccluder look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon,
                       const Rotation* turn = nullptr);

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

inline Vec3f ViewedOccluder::viewed(const Vec3f& position) const {
    Vec3f from = position - view_point;
    if (is_turned) {
        const auto along = [&](const Vec3f& axis) {
            return (axis.x * from.x + axis.y * from.y) + axis.z * from.z;
        };
        from = Vec3f(along(axes[0]), along(axes[1]), along(axes[2]));
    }
    const auto never_0 = [](float coordinate) { return coordinate == 0 ? almost_zero : coordinate; };
    return {never_0(from.x), never_0(from.y), never_0(from.z)};
}

}  // namespace haarfield
