/// Contour edges as lines on a cubemap face, classified by how to draw them.
/// Included once per instruction set, as Highway requires.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "fields/rasterizer/edge_lines-inl.h"
#include "fields/rasterizer/lane_compaction-inl.h"
#include "fields/rasterizer/layers_along_axis.h"
#include "fields/rasterizer/visible_contour.h"

#ifndef HAARFIELD_FIELDS_CONTOUR_LINES_ONCE
#define HAARFIELD_FIELDS_CONTOUR_LINES_ONCE

namespace haarfield {

/// The number of edges per batch, chosen so that their data stay in the nearest cache.
inline constexpr std::size_t edges_at_a_time = 1024;
/// The distance between two arrays of a batch: padded by a vector, and not a multiple of a page.
inline constexpr std::size_t edges_stride = edges_at_a_time + 16;

/// The data of a line for drawing. Rows and sub-columns are numbered from 0. The line crosses the sub-columns
/// [begin, end) at row  slope * c + constant,  clamped.
///
/// A sample on an edge is blocked. So if layers begin, the first changed sample is the one on the edge or the
/// first below; if layers end, the first changed sample is the first one below.
enum LineData : std::size_t {
    line_begin,
    line_end,
    line_change,  ///< Change of the number of layers, downwards.
    line_slope,
    line_constant,
    line_lowest,
    line_highest,
    line_data_count
};

/// Structure of arrays, each edges_stride floats long.
struct LineList {
    float* lines;
    std::size_t count = 0;

    const float* data(LineData k) const { return lines + k * edges_stride; }
};

/// The lines of a face.
struct FaceLines {
    LineList in_front;
    LineList above;  ///< Above the first row; without slope, constant, lowest and highest.

    static constexpr std::size_t floats = 2 * line_data_count * edges_stride;
    explicit FaceLines(float* lines) : in_front{lines}, above{lines + line_data_count * edges_stride} {}
};

/// The region of a face that a contour changes: rows [top, bottom) and sub-columns [left, right). `beginning`
/// sums all layers that begin, an upper bound for any sample.
struct ContourExtent {
    float top = INFINITY, bottom = 0, left = INFINITY, right = 0, beginning = 0;
};

/// Bound of the relative rounding error of a component of a cross product, with a margin.
inline constexpr float sign_doubt = 1e-6f;

}  // namespace haarfield

#endif

#if defined(HAARFIELD_FIELDS_CONTOUR_LINES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_FIELDS_CONTOUR_LINES_INL_H
#undef HAARFIELD_FIELDS_CONTOUR_LINES_INL_H
#else
#define HAARFIELD_FIELDS_CONTOUR_LINES_INL_H
#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Decides in exact arithmetic which edges run to larger u, for edges too close to a pole for floats.
HWY_INLINE VF exact_turn(hn::Mask<Floats> doubtful, const FaceVertices& p, const FaceVertices& q,
                         const FaceComponents& frame, VF turn) {
    const Floats d;
    enum { p_u, p_w, q_u, q_w, turns, count };
    alignas(64) float lanes[count][16];
    hn::Store(p.u, d, lanes[p_u]);
    hn::Store(p.w, d, lanes[p_w]);
    hn::Store(q.u, d, lanes[q_u]);
    hn::Store(q.w, d, lanes[q_w]);
    hn::Store(turn, d, lanes[turns]);
    std::uint8_t mask[8] = {};
    hn::StoreMaskBits(d, doubtful, mask);
    for (std::size_t i = 0; i < hn::Lanes(d); ++i)
        if (mask[i / 8] >> (i % 8) & 1)
            lanes[turns][i] =
                runs_to_larger_u(lanes[p_u][i], lanes[p_w][i], lanes[q_u][i], lanes[q_w][i], frame) ? 1.0f
                                                                                                    : -1.0f;
    return hn::Load(d, lanes[turns]);
}

/// Adds lines of a face to its lists: those of `count` of its contour edges, at most edges_at_a_time.
inline HWY_NOINLINE void set_up_lines(const VisibleContour& contour, std::size_t first, std::size_t count,
                                      int face, int face_size, FaceLines& lines, ContourExtent& extent) {
    const FaceComponents frame = all_face_components[face];
    const VisibleContour::OfFace& edges = contour.of_face[std::size_t(face)];
    const Floats d;
    FaceLines to = lines;
    const VF zero = hn::Zero(d), one = hn::Set(d, 1.0f), far = hn::Set(d, 1e9f),
             rows = hn::Set(d, static_cast<float>(face_size)), half = hn::Mul(rows, hn::Set(d, 0.5f)),
             columns = hn::Mul(rows, hn::Set(d, 8.0f));
    VF top = hn::Set(d, extent.top), bottom = hn::Set(d, extent.bottom), left = hn::Set(d, extent.left),
       right = hn::Set(d, extent.right), beginning = zero;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto end_of = [&](std::size_t s) -> FaceVertices {
            const auto component = [&](std::size_t k) {
                const float* from = edges.ends[3 * s + std::size_t(frame.component[k])].data();
                return hn::Mul(hn::LoadU(d, from + first + i), hn::Set(d, frame.sign[k]));
            };
            return {component(0), component(1), component(2)};
        };
        const FaceVertices p = end_of(0), q = end_of(1);
        EdgeLine line = edge_line(p, q, face_size);
        const VF left_of_p = sub_columns_left_of(p, face_size), left_of_q = sub_columns_left_of(q, face_size);
        const auto p_ahead = hn::Gt(p.w, zero), q_ahead = hn::Gt(q.w, zero);
        const auto both = hn::And(p_ahead, q_ahead), either = hn::Or(p_ahead, q_ahead);

        // For an edge with one end behind the plane w = 0: the v at which it crosses that plane, up to a
        // positive factor. Its sign determines whether the edge leaves upwards (to smaller rows than the end
        // ahead) or downwards. Within the rounding error, neither is certain.
        const VF leaves = hn::Sub(hn::Mul(q.v, p.w), hn::Mul(p.v, q.w)),
                 leaves_at = hn::IfThenElse(p_ahead, leaves, hn::Neg(leaves)),
                 leaves_doubt = hn::Mul(hn::Set(d, sign_doubt),
                                        hn::Add(hn::Abs(hn::Mul(q.v, p.w)), hn::Abs(hn::Mul(p.v, q.w))));
        const auto doubtful = hn::AndNot(
            both, hn::And(either, hn::Or(hn::Not(line.crosses),
                                         hn::Le(hn::Abs(line.turn),
                                                hn::Mul(hn::Set(d, sign_doubt), line.turn_terms)))));
        VF turn = hn::IfThenElse(both, hn::Sub(left_of_q, left_of_p), line.turn);
        if (!hn::AllFalse(d, doubtful)) {
            // The edge passes a pole so closely that it crosses all sub-columns there.
            turn = exact_turn(doubtful, p, q, frame, turn);
            line.slope = hn::IfThenElse(doubtful, zero, line.slope);
            line.constant = hn::IfThenElse(
                doubtful, hn::IfThenElse(hn::Gt(leaves_at, zero), far, hn::Neg(far)), line.constant);
        }
        const auto rightwards = hn::Gt(turn, zero);
        // An edge with its end behind runs to the first or last of all sub-columns.
        const VF from = hn::IfThenElse(p_ahead, left_of_p, hn::IfThenElse(rightwards, zero, columns)),
                 until = hn::IfThenElse(q_ahead, left_of_q, hn::IfThenElse(rightwards, columns, zero)),
                 begin = hn::Min(from, until), end = hn::Max(from, until);
        const auto drawn = hn::And(hn::And(either, hn::Lt(begin, end)), hn::FirstN(d, count - i));

        // Clamp rows to those between the ends, or beyond the end ahead, with a margin for rounding, and to
        // the face.
        const VF row_p = hn::Mul(hn::Add(hn::Div(p.v, p.w), one), half),
                 row_q = hn::Mul(hn::Add(hn::Div(q.v, q.w), one), half),
                 row_ahead = hn::IfThenElse(p_ahead, row_p, row_q);
        // An edge so steep that, in all sub-columns between its ends, it is clamped to its farther end,
        // outside of the face.
        const auto is_steep = hn::AndNot(line.crosses, both);
        line.slope = hn::IfThenZeroElse(is_steep, line.slope);
        line.constant = hn::IfThenElse(
            is_steep, hn::IfThenElse(hn::Gt(hn::Abs(row_p), hn::Abs(row_q)), row_p, row_q), line.constant);
        const auto downwards = hn::Gt(leaves_at, leaves_doubt),
                   upwards = hn::Lt(leaves_at, hn::Neg(leaves_doubt));
        const VF upper =
                     hn::IfThenElse(both, hn::Min(row_p, row_q),
                                    hn::IfThenElse(hn::AndNot(doubtful, downwards), row_ahead, hn::Neg(far))),
                 lower = hn::IfThenElse(both, hn::Max(row_p, row_q),
                                        hn::IfThenElse(hn::AndNot(doubtful, upwards), row_ahead, far));
        const VF slack = hn::Set(d, 0.01f);
        const VF lowest = hn::Min(hn::Max(hn::Sub(upper, slack), zero), rows),
                 highest = hn::Min(hn::Max(hn::Add(lower, slack), zero), rows);

        // Downwards across the edge, the layers of the triangle above end and those of the triangle below
        // begin.
        const VF weight = hn::LoadU(d, edges.weights.data() + first + i),
                 change = hn::IfThenElse(rightwards, hn::Neg(weight), weight);
        const auto begins = hn::Gt(change, zero);
        const auto add = [&](LineList& list, hn::Mask<Floats> mask, bool complete) {
            const ChosenLanes<Floats> chosen(d, mask);
            float* at = list.lines + list.count;
            const auto store = [&](LineData k, VF value) { chosen.store(value, d, at + k * edges_stride); };
            store(line_begin, begin);
            store(line_end, end);
            store(line_change, change);
            if (complete) {
                store(line_slope, line.slope);
                store(line_constant, line.constant);
                store(line_lowest, lowest);
                store(line_highest, highest);
            }
            list.count += chosen.count();
        };
        const auto is_above = hn::Eq(highest, zero), is_below = hn::Eq(lowest, rows);
        add(to.in_front, hn::AndNot(hn::Or(is_above, is_below), drawn), true);
        add(to.above, hn::And(drawn, is_above), false);
        top = hn::Min(top, hn::IfThenElse(drawn, lowest, top));
        bottom = hn::Max(bottom, hn::IfThenElse(drawn, highest, bottom));
        left = hn::Min(left, hn::IfThenElse(drawn, begin, left));
        right = hn::Max(right, hn::IfThenElse(drawn, end, right));
        beginning = hn::Add(beginning, hn::IfThenElseZero(hn::And(drawn, begins), change));
    }
    lines = to;
    extent = {hn::GetLane(hn::MinOfLanes(d, top)), hn::GetLane(hn::MaxOfLanes(d, bottom)),
              hn::GetLane(hn::MinOfLanes(d, left)), hn::GetLane(hn::MaxOfLanes(d, right)),
              extent.beginning + hn::GetLane(hn::SumOfLanes(d, beginning))};
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
