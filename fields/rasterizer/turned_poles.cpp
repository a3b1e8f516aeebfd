#include "fields/rasterizer/turned_poles.h"

#include <algorithm>
#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/rasterizer/turned_poles.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fields/rasterizer/lane_compaction-inl.h"
#include "fields/rasterizer/layers_along_axis.h"
#include "fields/rasterizer/viewed_occluder-inl.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

HWY_INLINE VF component(const ViewedVertices& v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/// Lists the edges' clusters whose boxes an axis may meet.
///
/// slack  bound of rounding errors. [m]
std::size_t list_clusters_near_axes(const OccluderEdges& edges, const ViewedOccluder& viewed, float slack,
                                    std::uint32_t* near) {
    const Floats d;
    const hn::RebindToUnsigned<Floats> du;
    const auto count = static_cast<std::uint32_t>(edges.clusters.size());
    const std::uint32_t* const begin = near;
    auto numbers = hn::Iota(du, 0u);
    for (std::uint32_t first = 0; first < count; first += static_cast<std::uint32_t>(hn::Lanes(d))) {
        const auto dot = [&](const auto& box, const Vec3f& v) {
            const auto term = [&](std::size_t k, float factor) {
                return hn::Mul(hn::LoadU(d, box[k].data() + first), hn::Set(d, factor));
            };
            return hn::Add(hn::Add(term(0, v.x), term(1, v.y)), term(2, v.z));
        };
        hn::Mask<Floats> misses[3];
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f& axis = viewed.axes[k];
            const VF distance =
                         hn::Sub(dot(edges.vertices.middle, axis), hn::Set(d, axis.dot(viewed.view_point))),
                     extent = dot(edges.vertices.half_extent,
                                  Vec3f(std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)));
            misses[k] = hn::Gt(hn::Abs(distance), hn::Add(extent, hn::Set(d, slack)));
        }
        // The box is on one side of an axis if it is on one side along either of the other two.
        const auto all_miss = hn::Or(hn::Or(hn::And(misses[0], misses[1]), hn::And(misses[1], misses[2])),
                                     hn::And(misses[2], misses[0]));
        const auto chosen = hn::AndNot(all_miss, hn::FirstN(d, count - first));
        const ChosenLanes<hn::RebindToUnsigned<Floats>> lanes(du, hn::RebindMask(du, chosen));
        lanes.store(numbers, du, near);
        near += lanes.count();
        numbers = hn::Add(numbers, hn::Set(du, static_cast<std::uint32_t>(hn::Lanes(d))));
    }
    return static_cast<std::size_t>(near - begin);
}

/// Returns the lanes in which an axis may be inside a triangle.
HWY_INLINE hn::Mask<Floats> may_surround(const ViewedVertices& p, const ViewedVertices& q,
                                         const ViewedVertices& r, int axis) {
    const Floats d;
    const AxisFrame& frame = axis_frames[std::size_t(axis)];
    const auto side = [&](const ViewedVertices& a, const ViewedVertices& b, int sign) {
        constexpr float rounding = 1e-6f;
        const VF left = hn::Mul(component(a, frame.across), component(b, frame.up)),
                 right = hn::Mul(component(a, frame.up), component(b, frame.across)),
                 error = hn::Mul(hn::Set(d, rounding), hn::Add(hn::Abs(left), hn::Abs(right)));
        return sign > 0 ? hn::Gt(hn::Sub(left, right), error) : hn::Gt(hn::Sub(right, left), error);
    };
    const auto any = [&](int sign) {
        return hn::Or(hn::Or(side(p, q, sign), side(q, r, sign)), side(r, p, sign));
    };
    return hn::Not(hn::And(any(1), any(-1)));
}

/// Adds the triangles of a cluster that an axis may meet.
void list_triangles(const Occluder& occluder, const ViewedOccluder& viewed, std::uint32_t number,
                    std::vector<std::uint32_t>& triangles) {
    const Floats d;
    constexpr std::size_t size = OccluderEdges::cluster_size;
    const OccluderEdges::Cluster& cluster = occluder.edges().clusters[number];
    for (std::size_t first = 0; first < 2 * size; first += hn::Lanes(d)) {
        const auto side = [&](std::size_t lane) { return (first + lane) / size; };
        const auto edge = [&](std::size_t lane) { return (first + lane) % size; };
        const auto end = [&](std::size_t s) {
            return gather_viewed_vertices([&](std::size_t k) { return cluster.ends[edge(k)][s]; }, viewed);
        };
        const ViewedVertices p = end(0), q = end(1),
                             r = gather_viewed_vertices(
                                 [&](std::size_t k) {
                                     return occluder.padded_positions().data() +
                                            4 * std::size_t(cluster.apices[side(k)][edge(k)]);
                                 },
                                 viewed);
        const auto met =
            hn::Or(hn::Or(may_surround(p, q, r, 0), may_surround(p, q, r, 1)), may_surround(p, q, r, 2));
        for (std::uint64_t rest = bits_of(d, met); rest != 0; rest &= rest - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
            const std::uint32_t t = cluster.triangles[side(lane)][edge(lane)];
            if (t < occluder.triangles().size()) triangles.push_back(t);
        }
    }
}

/// Lists the triangles that an axis may meet; some of them several times.
void list_triangles_near_axes(const Occluder& occluder, const ViewedOccluder& viewed, TurnedPoles& poles) {
    const float slack = 1e-5f * (occluder.bounds().radius() + viewed.from_centre.length());
    poles.triangles.clear();
    const std::size_t count = list_clusters_near_axes(occluder.edges(), viewed, slack, poles.clusters.data());
    for (std::size_t i = 0; i < count; ++i)
        list_triangles(occluder, viewed, poles.clusters.data()[i], poles.triangles);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(list_triangles_near_axes);

namespace {

/// Returns the layers in the negative direction minus those in the positive one. Both sides of an edge change
/// by its weight at the half-plane through the axis in which the coordinate across is positive.
int difference_of_poles(const VisibleContour& contour, int axis) {
    const auto [across, up] = axis_frames[std::size_t(axis)];
    int sum = 0;
    for (std::size_t i = 0; i < contour.count; ++i) {
        const auto end = [&](std::size_t s, int k) {
            return contour.viewed_ends[3 * s + std::size_t(k)].data()[i];
        };
        const float p_up = end(0, up), q_up = end(1, up);
        if ((p_up < 0) == (q_up < 0)) continue;
        const float p_across = end(0, across), q_across = end(1, across);
        const bool rises = p_up < 0;
        if (turns_left(p_across, p_up, q_across, q_up) == rises)
            sum += static_cast<int>(contour.weights.data()[i]) * (rises ? 1 : -1);
    }
    return sum;
}

}  // namespace

void find_turned_poles(const Occluder& occluder, const ViewedOccluder& viewed, const VisibleContour& contour,
                       TurnedPoles& poles) {
    const Vec3f to_centre = occluder.bounds().centre() - viewed.view_point;
    if (to_centre.length() > 1.001f * occluder.bounds().radius()) {
        for (int axis = 0; axis < 3; ++axis) {
            const int difference = difference_of_poles(contour, axis);
            poles.layers[std::size_t(axis)] = {std::max(difference, 0), std::max(-difference, 0)};
        }
        return;
    }
    poles.layers = {};
    poles.clusters.reserve(occluder.edges().clusters.size() + widest_vector<std::uint32_t>);
    HWY_DYNAMIC_DISPATCH(list_triangles_near_axes)(occluder, viewed, poles);
    std::sort(poles.triangles.begin(), poles.triangles.end());
    poles.triangles.erase(std::unique(poles.triangles.begin(), poles.triangles.end()), poles.triangles.end());
    for (const std::uint32_t t : poles.triangles) {
        const std::array<Vec3f, 3> triangle = viewed_triangle(occluder, viewed, t);
        const int facing_of = facing(occluder, viewed, t);
        if (facing_of == 0) continue;
        for (int axis = 0; axis < 3; ++axis)
            if (const int turn = turn_around_axis(triangle, axis); turn != 0)
                ++poles.layers[std::size_t(axis)][turn * facing_of < 0];
    }
}

}  // namespace haarfield
#endif
