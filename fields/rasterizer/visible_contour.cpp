#include "fields/rasterizer/visible_contour.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/rasterizer/visible_contour.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fields/rasterizer/lane_compaction-inl.h"
#include "fields/rasterizer/viewed_occluder-inl.h"

#ifndef HAARFIELD_VISIBLE_CONTOUR_ONCE
#define HAARFIELD_VISIBLE_CONTOUR_ONCE

namespace haarfield {

/// Bound of the relative rounding error of the sums that classify a box, with a margin.
inline constexpr float box_rounding = 4e-6f;

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Determines which vertices are below the horizon.
void tell_below(const Occluder& occluder, const ViewedOccluder& viewed, std::uint8_t* below) {
    const Floats d;
    const Codes di;
    const hn::Rebind<std::uint8_t, Floats> bytes;
    for (std::size_t v = 0; v < occluder.positions().size(); v += hn::Lanes(d)) {
        const ViewedVertices at = load_viewed_vertices(occluder.padded_positions().data() + 4 * v, viewed);
        const auto is_below = hn::Le(height_over_view_point(at, viewed.up), hn::Set(d, viewed.lowest));
        hn::StoreU(hn::DemoteTo(bytes, hn::IfThenElseZero(hn::RebindMask(di, is_below), hn::Set(di, 1))),
                   bytes, below + v);
    }
}

/// Lists the clusters above the horizon that may have contour edges, and all clusters that the horizon may
/// cut.
void list_clusters(const OccluderEdges& edges, float radius, const ViewedOccluder& viewed,
                   VisibleContour& contour) {
    const Floats d;
    const hn::RebindToUnsigned<Floats> du;
    const Vec3f &p = viewed.from_centre, &up = viewed.object_up;
    const auto absolute = [](const Vec3f& v) { return Vec3f(std::abs(v.x), std::abs(v.y), std::abs(v.z)); };
    const Vec3f p_extent = absolute(p), up_extent = absolute(up);
    const VF thin = hn::Set(d, viewed.thin), rounding = hn::Set(d, box_rounding * (p.length() + radius));
    const auto count = static_cast<std::uint32_t>(edges.clusters.size());
    auto numbers = hn::Iota(du, 0u);
    std::uint32_t *open_end = contour.open.data(), *cut_end = contour.cut.data();
    for (std::uint32_t first = 0; first < count; first += static_cast<std::uint32_t>(hn::Lanes(d))) {
        const auto load = [&](const std::vector<float>& values) {
            return hn::LoadU(d, values.data() + first);
        };
        const auto dot = [&](const auto& box, const Vec3f& v) {
            return hn::Add(
                hn::Add(hn::Mul(load(box[0]), hn::Set(d, v.x)), hn::Mul(load(box[1]), hn::Set(d, v.y))),
                hn::Mul(load(box[2]), hn::Set(d, v.z)));
        };
        // In the dual space, a plane is a point, and the view point is a plane.
        const VF slack = hn::Add(hn::Mul(load(edges.per_altitude), thin), rounding);
        hn::Mask<Floats> front[2], back[2];
        for (std::size_t s = 0; s < 2; ++s) {
            const SoaBoxes<4>& box = edges.planes[s];
            const VF away = hn::Sub(dot(box.middle, p), load(box.middle[3])),
                     reach =
                         hn::Add(hn::Add(dot(box.half_extent, p_extent), load(box.half_extent[3])), slack);
            front[s] = hn::Gt(away, reach);
            back[s] = hn::Lt(away, hn::Neg(reach));
        }
        const auto valid = hn::FirstN(d, count - first);
        const auto all_front = hn::And(front[0], front[1]), all_back = hn::And(back[0], back[1]);
        auto open = hn::AndNot(hn::Or(all_front, all_back), valid);
        if (viewed.horizon) {
            const auto from = [&](std::size_t k, float origin) {
                return hn::Sub(load(edges.vertices.middle[k]), hn::Set(d, origin));
            };
            const ViewedVertices middle{from(0, viewed.view_point.x), from(1, viewed.view_point.y),
                                        from(2, viewed.view_point.z)};
            const VF height = hn::Sub(height_over_view_point(middle, up), hn::Set(d, viewed.lowest)),
                     distance = hn::Add(hn::Add(hn::Abs(middle.x), hn::Abs(middle.y)), hn::Abs(middle.z)),
                     extent = hn::Add(
                         hn::Mul(hn::Set(d, 1 + box_rounding), dot(edges.vertices.half_extent, up_extent)),
                         hn::Mul(hn::Set(d, box_rounding), distance));
            const auto above = hn::Gt(height, extent), below = hn::Lt(height, hn::Neg(extent));
            open = hn::And(open, above);
            // One-sided triangles that are all back-facing are invisible.
            const auto unseen =
                hn::And(all_back, hn::RebindMask(d, hn::Lt(numbers, hn::Set(du, edges.one_sided_clusters))));
            const ChosenLanes<hn::RebindToUnsigned<Floats>> cut(
                du, hn::RebindMask(du, hn::AndNot(hn::Or(hn::Or(above, below), unseen), valid)));
            cut.store(numbers, du, cut_end);
            cut_end += cut.count();
        }
        const ChosenLanes<hn::RebindToUnsigned<Floats>> chosen(du, hn::RebindMask(du, open));
        chosen.store(numbers, du, open_end);
        open_end += chosen.count();
        numbers = hn::Add(numbers, hn::Set(du, static_cast<std::uint32_t>(hn::Lanes(d))));
    }
    contour.open_count = static_cast<std::size_t>(open_end - contour.open.data());
    contour.cut_count = static_cast<std::size_t>(cut_end - contour.cut.data());
}

using ClusterFloats = hn::CappedTag<float, OccluderEdges::cluster_size>;
using ClusterNumbers = hn::RebindToUnsigned<ClusterFloats>;

/// Returns the facing (viewed_occluder.h) of triangles on one side of a cluster's edges, without the horizon.
/// Visible triangles that appear thin are left to the span rasterizer.
HWY_INLINE hn::Vec<ClusterFloats> facings(hn::Vec<ClusterFloats> heights, const std::uint32_t* triangles,
                                          std::uint32_t one_sided, float thin, VisibleContour& contour) {
    const ClusterFloats d;
    const ClusterNumbers du;
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f), limit = hn::Set(d, thin);
    const auto is_one_sided = hn::RebindMask(d, hn::Lt(hn::LoadU(du, triangles), hn::Set(du, one_sided)));
    const auto is_seen = hn::Or(hn::Gt(heights, zero), hn::AndNot(is_one_sided, hn::Lt(heights, zero)));
    const auto is_thin = hn::Le(hn::Abs(heights), limit);
    for (std::uint64_t rest = bits_of(d, hn::And(is_seen, is_thin)); rest != 0; rest &= rest - 1) {
        const std::uint32_t t = triangles[std::countr_zero(rest)];
        contour.left[t / 64] |= std::uint64_t(1) << (t % 64);
    }
    return hn::IfThenElseZero(hn::AndNot(is_thin, is_seen),
                              hn::IfThenElse(hn::Gt(heights, zero), one, hn::Neg(one)));
}

struct TrianglesBelow {
    hn::Mask<ClusterFloats> left, right;
};

/// Determines which triangles at a vector of a cluster's edges have all vertices below the horizon.
HWY_INLINE TrianglesBelow triangles_below(const OccluderEdges::Cluster& cluster, std::size_t first,
                                          const std::uint8_t* below) {
    const ClusterFloats d;
    unsigned left = 0, right = 0;
    for (std::size_t i = 0; i < hn::Lanes(d); ++i) {  // branch-free
        const auto is_below = [&](const std::uint32_t* vertices) {
            return unsigned(below[vertices[first + i]]);
        };
        const unsigned ends = is_below(cluster.vertices[0]) & is_below(cluster.vertices[1]);
        left |= (ends & is_below(cluster.apices[0])) << i;
        right |= (ends & is_below(cluster.apices[1])) << i;
    }
    const std::uint8_t left_bits[8] = {static_cast<std::uint8_t>(left)},
                       right_bits[8] = {static_cast<std::uint8_t>(right)};
    return {hn::LoadMaskBits(d, left_bits), hn::LoadMaskBits(d, right_bits)};
}

/// Lists the contour edges of clusters, and the triangles left to the span rasterizer.
///
/// horizon  true if the horizon may cut the clusters; otherwise they are above it.
void list_edges(const Occluder& occluder, const ViewedOccluder& viewed, const std::uint32_t* clusters,
                std::size_t cluster_count, bool horizon, VisibleContour& contour) {
    const ClusterFloats d;
    const ClusterNumbers du;
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f), thin = hn::Set(d, viewed.thin);
    const Vec3f from_centre = viewed.from_centre;
    float* weights = contour.weights.data();
    std::uint32_t* numbers = contour.numbers.data();
    std::size_t count = contour.count;
    const auto lanes = hn::Iota(du, 0u);
    for (std::size_t i = 0; i < cluster_count; ++i) {
        const OccluderEdges::Cluster& cluster = occluder.edges().clusters[clusters[i]];
        for (std::size_t e = 0; e < OccluderEdges::cluster_size; e += hn::Lanes(d)) {
            const auto heights = [&](std::size_t s) {
                const auto& planes = cluster.planes[s];
                return heights_over_planes(d, planes[0] + e, planes[1] + e, planes[2] + e, planes[3] + e,
                                           from_centre);
            };
            const auto left = heights(0), right = heights(1);
            auto facing_left = hn::IfThenElseZero(hn::Gt(left, zero), one),
                 facing_right = hn::IfThenElseZero(hn::Gt(right, zero), one);
            const auto any_thin = hn::Or(hn::Le(hn::Abs(left), thin), hn::Le(hn::Abs(right), thin));
            if (clusters[i] >= occluder.edges().one_sided_clusters || !hn::AllFalse(d, any_thin)) {
                facing_left =
                    facings(left, cluster.triangles[0] + e, occluder.one_sided(), viewed.thin, contour);
                facing_right =
                    facings(right, cluster.triangles[1] + e, occluder.one_sided(), viewed.thin, contour);
            }
            if (horizon) {
                const auto [left_below, right_below] = triangles_below(cluster, e, contour.below.data());
                facing_left = hn::IfThenZeroElse(left_below, facing_left);
                facing_right = hn::IfThenZeroElse(right_below, facing_right);
            }
            const auto weight = hn::Sub(facing_left, facing_right);
            const auto differs = hn::RebindMask(du, hn::Ne(weight, zero));
            const ChosenLanes<ClusterNumbers> chosen(du, differs);
            chosen.store(hn::BitCast(du, weight), du, reinterpret_cast<std::uint32_t*>(weights) + count);
            const std::size_t first = clusters[i] * OccluderEdges::cluster_size + e;
            chosen.store(hn::Add(lanes, hn::Set(du, static_cast<std::uint32_t>(first))), du, numbers + count);
            count += chosen.count();
        }
    }
    contour.count = count;
}

/// Copies the contour edges into a list per face.
void sort_by_face(const Occluder& occluder, const ViewedOccluder& viewed, VisibleContour& contour) {
    const Floats d;
    const hn::RebindToUnsigned<Floats> du;
    float* to[cubemap_faces][7];
    // rounded up, so that buffers rarely grow
    const std::size_t room = std::bit_ceil(contour.count) + hn::MaxLanes(d);
    std::uint32_t outside[cubemap_faces];
    if (viewed.is_turned)
        for (AlignedBuffer<float>& ends : contour.viewed_ends) ends.reserve(room);
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        VisibleContour::OfFace& of_face = contour.of_face[face];
        for (std::size_t k = 0; k < 6; ++k) {
            of_face.ends[k].reserve(room);
            to[face][k] = of_face.ends[k].data();
        }
        of_face.weights.reserve(room);
        to[face][6] = of_face.weights.data();
        outside[face] = outside_left_or_right(int(face)) | outside_below(int(face));
    }
    std::size_t counts[cubemap_faces] = {};
    for (std::size_t i = 0; i < contour.count; i += hn::Lanes(d)) {
        const std::uint32_t* numbers = contour.numbers.data() + i;
        const auto end = [&](std::size_t s) {
            return gather_viewed_vertices(
                [&](std::size_t k) { return edge_ends(occluder.edges(), numbers[k])[s]; }, viewed);
        };
        const ViewedVertices p = end(0), q = end(1);
        const VF values[7] = {p.x, p.y, p.z, q.x, q.y, q.z, hn::Load(d, contour.weights.data() + i)};
        if (viewed.is_turned)
            for (std::size_t k = 0; k < 6; ++k) hn::StoreU(values[k], d, contour.viewed_ends[k].data() + i);
        const auto codes = hn::BitCast(du, common_outcodes(p, q));
        const auto valid = hn::FirstN(du, contour.count - i);
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            const auto inside =
                hn::And(valid, hn::Eq(hn::And(codes, hn::Set(du, outside[face])), hn::Zero(du)));
            if (hn::AllFalse(du, inside)) continue;
            const ChosenLanes<Floats> chosen(d, hn::RebindMask(d, inside));
            for (std::size_t k = 0; k < 7; ++k) chosen.store(values[k], d, to[face][k] + counts[face]);
            counts[face] += chosen.count();
        }
    }
    for (std::size_t face = 0; face < cubemap_faces; ++face) contour.of_face[face].count = counts[face];
}

void find_contour(const Occluder& occluder, const ViewedOccluder& viewed, VisibleContour& contour) {
    const OccluderEdges& edges = occluder.edges();
    contour.left = edges.loose;
    contour.count = 0;
    if (viewed.horizon) tell_below(occluder, viewed, contour.below.data());
    list_clusters(edges, occluder.bounds().radius(), viewed, contour);
    list_edges(occluder, viewed, contour.open.data(), contour.open_count, false, contour);
    list_edges(occluder, viewed, contour.cut.data(), contour.cut_count, true, contour);
    // Padding with valid numbers for a whole vector.
    std::fill_n(contour.numbers.data() + contour.count, hn::MaxLanes(Floats()), 0u);
    sort_by_face(occluder, viewed, contour);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(find_contour);

void find_contour(const Occluder& occluder, const ViewedOccluder& viewed, VisibleContour& contour) {
    constexpr std::size_t lanes = widest_vector<std::uint32_t>;
    const std::size_t edges = OccluderEdges::cluster_size * occluder.edges().clusters.size() + lanes;
    contour.numbers.reserve(edges);
    contour.weights.reserve(edges);
    contour.open.reserve(occluder.edges().clusters.size() + lanes);
    contour.cut.reserve(occluder.edges().clusters.size() + lanes);
    contour.below.reserve(occluder.positions().size() + lanes);
    HWY_DYNAMIC_DISPATCH(find_contour)(occluder, viewed, contour);
}

}  // namespace haarfield
#endif
