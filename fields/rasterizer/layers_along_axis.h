#pragma once
/// Layers of an occluder along an axis through the view point, in exact arithmetic.

#include <array>

#include "fields/rasterizer/face_outcodes.h"
#include "fields/rasterizer/viewed_occluder.h"

namespace haarfield {

/// Tests on which side of an axis an edge from p to q passes: the sign of p_a q_b - p_b q_a. The coordinates
/// across (a) and up (b) form a right-handed frame with the axis. Exact, because products of two floats are
/// exact in double. If the edge meets the axis, the axis is perturbed by an infinitesimal along a and a
/// smaller one along b.
inline bool turns_left(float p_a, float p_b, float q_a, float q_b) {
    const double left = double(p_a) * double(q_b), right = double(p_b) * double(q_a);
    if (left != right) return left > right;
    return p_b != q_b ? p_b > q_b : q_a > p_a;
}

/// Tests whether an edge from p to q passes the poles of a face's sub-columns (its v axis) towards larger u.
inline bool runs_to_larger_u(float p_u, float p_w, float q_u, float q_w, const FaceComponents& frame) {
    const AxisFrame& axis = axis_frames[std::size_t(frame.component[1])];
    // Convert the face's coordinates to those of the axis.
    const bool u_is_across = frame.component[0] == axis.across;
    const float p_across = u_is_across ? p_u * frame.sign[0] : p_w * frame.sign[2],
                p_up = u_is_across ? p_w * frame.sign[2] : p_u * frame.sign[0],
                q_across = u_is_across ? q_u * frame.sign[0] : q_w * frame.sign[2],
                q_up = u_is_across ? q_w * frame.sign[2] : q_u * frame.sign[0];
    // w_p u_q - u_p w_q, in a frame that the signs rotate or mirror.
    const bool mirrored = u_is_across == (frame.sign[0] * frame.sign[2] > 0);
    return turns_left(p_across, p_up, q_across, q_up) != mirrored;
}

/// Tests on which side of an axis of the cubemap a triangle surrounds it: 1 if counter-clockwise as viewed
/// from the axis' positive end, -1 if clockwise, 0 if it does not surround the axis.
inline int turn_around_axis(const std::array<Vec3f, 3>& viewed, int axis) {
    const auto [across, up] = axis_frames[std::size_t(axis)];
    int left = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3f &p = viewed[k], &q = viewed[(k + 1) % 3];
        left += turns_left(p[across], p[up], q[across], q[up]);
    }
    return left == 3 ? 1 : left == 0 ? -1 : 0;
}

/// Returns the vertices of a triangle: ViewedOccluder::viewed.
inline std::array<Vec3f, 3> viewed_triangle(const Occluder& occluder, const ViewedOccluder& viewed,
                                            std::uint32_t triangle) {
    const auto& [i, j, k] = occluder.triangles()[triangle];
    return {viewed.viewed(occluder.positions()[i]), viewed.viewed(occluder.positions()[j]),
            viewed.viewed(occluder.positions()[k])};
}

/// Counts the layers of facing triangles along an axis, in the positive or negative direction. The occluder
/// is not turned.
inline int layers_along_axis(const Occluder& occluder, const ViewedOccluder& viewed, int axis,
                             bool to_larger) {
    const auto [across, up] = axis_frames[std::size_t(axis)];
    const Vec3f& from = viewed.view_point;
    if (to_larger ? from[axis] > occluder.bounds().upper[axis] : from[axis] < occluder.bounds().lower[axis])
        return 0;
    int layers = 0;
    const auto count_triangle = [&](std::uint32_t t) {
        // A triangle that surrounds the axis counter-clockwise lies in the negative direction if
        // front-facing.
        if (const int turn = turn_around_axis(viewed_triangle(occluder, viewed, t), axis); turn != 0)
            layers += facing(occluder, viewed, t) == (to_larger ? -turn : turn);
    };
    occluder.grids()[std::size_t(axis)].visit_triangles_at(double(from[across]), double(from[up]),
                                                           count_triangle);
    return layers;
}

}  // namespace haarfield
