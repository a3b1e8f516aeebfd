#include "fields/contour_rasterizer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#include "fields/layers_along_axis.h"
#include "fields/view_frame.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/contour_rasterizer.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fields/edge_lines-inl.h"

// The number of layers along a ray grows and falls where the ray's direction crosses the image of an edge: by
// one for each of its triangles that counts, up or down by the side on which it lies. On the common edge of
// two that are both seen from the front, or both from behind, one is entered as the other is left. What is
// left are contour edges. So each sub-column of a face is followed from the pole of all sub-columns, the
// direction -down, where the layers are counted once, and each contour edge changes their number where it
// crosses the sub-column. Every triangle counts as it is seen, whatever its winding: no sum is negative.
//
// Which sub-columns an edge crosses follows from its ends alone, so that the edges of a closed contour always
// agree about it. An edge with one end behind the face's plane w = 0 leaves by one of the poles; on which
// side of it tells the sign that counting the layers at the pole goes by, in exact arithmetic.

#ifndef HAARFIELD_CONTOUR_RASTERIZER_ONCE
#define HAARFIELD_CONTOUR_RASTERIZER_ONCE

namespace haarfield {

inline constexpr std::size_t line_queue_length = 64;
inline constexpr std::size_t line_queue_floats = 4 * line_queue_length;  ///< Of one of the two ends.
inline constexpr int most_layers = 255;                                  ///< That a counter holds.

/// What drawing needs of each edge in the queue: SoA, line_queue_length floats each. Rows and sub-columns are
/// counted from 0; the edge crosses the sub-columns [begin, end) at row  slope * c + constant,  clamped.
///
/// Where layers begin, the first sample on the edge or below it is changed; where they end, the first one
/// below: a sample on the edge is blocked. As  ceil(x) = -floor(-x),  of the former all rows are negative.
enum LineData : std::size_t {
    line_slope,
    line_constant,
    line_lowest,
    line_highest,
    line_begin,
    line_end,
    line_change,  ///< Downwards, of the number of layers.
    line_ends,    ///< 1 if layers end here, 0 if they begin.
    line_data_count
};

/// As row_offsets, for negative rows.
inline constexpr RowOffsets negative_row_offsets = [] {
    RowOffsets negative;
    for (float& row : negative.rows) row = -row;
    return negative;
}();

/// Relative rounding error of a component of a cross product, with room to spare.
inline constexpr float sign_doubt = 1e-6f;

/// The bits of 2^23 as a float. Those of 2^23 and a smaller integer are these and the integer's.
inline constexpr float float_offset = 0x1p23f;
inline constexpr std::size_t float_offset_bits = 0x4b000000;

/// Where sub-columns are, in texels from the middle of a face.
inline void fill_columns(int face_size, AlignedBuffer<float>& columns) {
    const std::size_t count = std::size_t(samples_per_texel * face_size) + 16;
    columns.reserve(count);
    for (std::size_t k = 0; k < count; ++k)
        columns.data()[k] =
            (static_cast<float>(k) + 0.5f) / samples_per_texel - 0.5f * static_cast<float>(face_size);
}

/// What a face's contour changes: rows [top, bottom) and sub-columns [left, right); and how many layers begin
/// all in all, more than there are anywhere.
struct ContourExtent {
    float top = INFINITY, bottom = 0, left = INFINITY, right = 0, beginning = 0;
};

/// Lists the contour edges that may cross sub-columns of a face, in sight or between them and the pole.
/// Returns how many.
inline std::size_t edges_of_face(const VisibleContour& contour, int face, std::uint32_t* edges) {
    const unsigned outside = outside_left_or_right(face) | outside_below(face);
    const std::uint32_t* outcodes = contour.outcodes.data();
    std::size_t listed = 0;
    for (std::uint32_t i = 0; i < contour.count; ++i) {  // no branch to guess wrong
        edges[listed] = i;
        listed += (outcodes[i] & outside) == 0;
    }
    return listed;
}

/// Copies edges to the queue: their first ends, then their second ones, then their weights.
inline void fill_queue(const VisibleContour& contour, const std::uint32_t* edges, std::size_t count,
                       float* queue) {
    for (std::size_t i = 0; i < count; ++i) {
        const float* ends = contour.ends.data() + 8 * std::size_t(edges[i]);
        std::memcpy(queue + 4 * i, ends, 16);
        std::memcpy(queue + line_queue_floats + 4 * i, ends + 4, 16);
        queue[2 * line_queue_floats + i] = contour.weights.data()[edges[i]];
    }
}

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Of edges that pass the poles too closely for floats, decides in exact arithmetic which run to larger u.
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

/// The lines of the queue's edges on a face.
void set_up_lines(const float* queue, std::size_t count, int face, int face_size, float* lines,
                  ContourExtent& extent) {
    const Floats d;
    const FaceComponents frame = all_face_components[face];
    const VF zero = hn::Zero(d), one = hn::Set(d, 1.0f), far = hn::Set(d, 1e9f),
             rows = hn::Set(d, static_cast<float>(face_size)), half = hn::Mul(rows, hn::Set(d, 0.5f)),
             columns = hn::Mul(rows, hn::Set(d, 8.0f));
    VF top = hn::Set(d, extent.top), bottom = hn::Set(d, extent.bottom), left = hn::Set(d, extent.left),
       right = hn::Set(d, extent.right), beginning = zero;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const FaceVertices p = load_vertices(queue + 4 * i, frame),
                           q = load_vertices(queue + line_queue_floats + 4 * i, frame);
        EdgeLine line = edge_line(p, q, face_size);
        const VF left_of_p = sub_columns_left_of(p, face_size), left_of_q = sub_columns_left_of(q, face_size);
        const auto p_ahead = hn::Gt(p.w, zero), q_ahead = hn::Gt(q.w, zero);
        const auto both = hn::And(p_ahead, q_ahead), either = hn::Or(p_ahead, q_ahead);

        // v where an edge with one end behind leaves, but for a positive factor: it does so upwards, to rows
        // below that of the end ahead, or downwards, or nobody knows.
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
            // So close to a pole that it meets all sub-columns there.
            turn = exact_turn(doubtful, p, q, frame, turn);
            line.slope = hn::IfThenElse(doubtful, zero, line.slope);
            line.constant = hn::IfThenElse(
                doubtful, hn::IfThenElse(hn::Gt(leaves_at, zero), far, hn::Neg(far)), line.constant);
        }
        const auto rightwards = hn::Gt(turn, zero);
        // An edge that ends behind runs to the left or right end of all sub-columns.
        const VF from = hn::IfThenElse(p_ahead, left_of_p, hn::IfThenElse(rightwards, zero, columns)),
                 to = hn::IfThenElse(q_ahead, left_of_q, hn::IfThenElse(rightwards, columns, zero)),
                 begin = hn::Min(from, to), end = hn::Max(from, to);
        const auto drawn = hn::And(hn::And(either, hn::Lt(begin, end)), hn::FirstN(d, count - i));

        // Between its ends, or beyond the one ahead, with room for rounding; and not far out of sight.
        const VF row_p = hn::Mul(hn::Add(hn::Div(p.v, p.w), one), half),
                 row_q = hn::Mul(hn::Add(hn::Div(q.v, q.w), one), half),
                 row_ahead = hn::IfThenElse(p_ahead, row_p, row_q);
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

        // Downwards: the layers of the triangle above end, those of the triangle below begin.
        const VF weight = hn::Load(d, queue + 2 * line_queue_floats + i),
                 change = hn::IfThenElse(rightwards, hn::Neg(weight), weight);
        const auto begins = hn::Gt(change, zero);
        const auto store = [&](LineData k, VF value) {
            hn::Store(value, d, lines + k * line_queue_length + i);
        };
        store(line_slope, hn::IfThenElse(begins, hn::Neg(line.slope), line.slope));
        store(line_constant, hn::IfThenElse(begins, hn::Neg(line.constant), line.constant));
        store(line_lowest, hn::IfThenElse(begins, hn::Neg(highest), lowest));
        store(line_highest, hn::IfThenElse(begins, hn::Neg(lowest), highest));
        store(line_begin, begin);
        store(line_end, hn::IfThenElse(drawn, end, begin));
        store(line_change, change);
        store(line_ends, hn::IfThenElse(begins, zero, one));
        top = hn::Min(top, hn::IfThenElse(drawn, lowest, top));
        bottom = hn::Max(bottom, hn::IfThenElse(drawn, highest, bottom));
        left = hn::Min(left, hn::IfThenElse(drawn, begin, left));
        right = hn::Max(right, hn::IfThenElse(drawn, end, right));
        beginning = hn::Add(beginning, hn::IfThenElseZero(hn::And(drawn, begins), change));
    }
    extent = {hn::GetLane(hn::MinOfLanes(d, top)), hn::GetLane(hn::MaxOfLanes(d, bottom)),
              hn::GetLane(hn::MinOfLanes(d, left)), hn::GetLane(hn::MaxOfLanes(d, right)),
              extent.beginning + hn::GetLane(hn::SumOfLanes(d, beginning))};
}

/// Lists where the lines cross sub-columns, and by how much the counter there changes. Returns how many
/// crossings there are.
std::size_t list_crossings(const float* lines, std::size_t count, int face_size, ContourScratch& scratch) {
    const Floats d;
    const hn::RebindToUnsigned<Floats> du;
    const std::size_t lanes = hn::Lanes(d);
    std::uint8_t drawn[line_queue_length];
    std::size_t drawn_count = 0;
    for (std::size_t i = 0; i < count; ++i) {  // no branch to guess wrong
        drawn[drawn_count] = static_cast<std::uint8_t>(i);
        drawn_count += lines[line_begin * line_queue_length + i] < lines[line_end * line_queue_length + i];
    }
    const float* columns = scratch.columns.data();
    std::uint32_t* crossings = scratch.crossings.data();
    std::uint8_t* changes = scratch.changes.data();
    const auto stride = static_cast<float>(samples_per_texel * face_size);
    const VF lane = hn::Iota(d, float_offset);
    std::size_t listed = 0;
    for (std::size_t n = 0; n < drawn_count; ++n) {
        const auto data = [&](LineData k) { return lines[k * line_queue_length + drawn[n]]; };
        const auto begin = static_cast<std::int32_t>(data(line_begin)),
                   end = static_cast<std::int32_t>(data(line_end));
        const auto change = static_cast<std::uint8_t>(static_cast<std::int32_t>(data(line_change)));
        const float ends = data(line_ends);
        const float* offsets = (ends != 0 ? row_offsets : negative_row_offsets).rows.data();
        const VF slope = hn::Set(d, data(line_slope)), constant = hn::Set(d, data(line_constant));
        const VF lowest = hn::Set(d, data(line_lowest)), highest = hn::Set(d, data(line_highest));
        const VF signed_stride = hn::Set(d, (2 * ends - 1) * stride);
        for (std::int32_t k = begin; k < end; k += static_cast<std::int32_t>(lanes)) {
            const VF line = hn::Min(
                hn::Max(hn::Add(hn::Mul(slope, hn::LoadU(d, columns + k)), constant), lowest), highest);
            const VF row = hn::Floor(hn::Sub(line, hn::LoadU(d, offsets + (k & 7))));
            const VF sub_column = hn::Add(lane, hn::Set(d, static_cast<float>(k) + ends * stride));
            // Whole numbers below 2^24: exact, whether or not there is an instruction for it.
            hn::StoreU(hn::BitCast(du, hn::MulAdd(row, signed_stride, sub_column)), du, crossings + listed);
            std::memset(changes + listed, change, 16);
            listed += std::min(lanes, static_cast<std::size_t>(end - k));
        }
    }
    return listed;
}

/// Adds the counters up, from the first row to the last, and clears them; a bit a sample that has layers.
void sum_layers(int face_size, int at_pole, const ContourExtent& extent, std::uint8_t* counters,
                std::uint8_t* blocked) {
    const auto size = static_cast<std::size_t>(face_size), stride = samples_per_texel * size;
    const auto top = static_cast<std::size_t>(extent.top), left = static_cast<std::size_t>(extent.left),
               right = static_cast<std::size_t>(extent.right);
    std::memset(blocked, at_pole > 0 ? 255 : 0, size * size);
#if HWY_TARGET == HWY_SCALAR
    for (std::size_t k = left; k < right; ++k) {
        auto layers = static_cast<std::uint8_t>(at_pole);
        for (std::size_t r = top; r < size; ++r) {
            layers = static_cast<std::uint8_t>(layers + counters[r * stride + k]);
            std::uint8_t& bits = blocked[r * size + k / 8];
            bits = static_cast<std::uint8_t>((bits & ~(1u << k % 8)) | unsigned(layers != 0) << k % 8);
            counters[r * stride + k] = 0;
        }
        counters[size * stride + k] = 0;
    }
#else
    const hn::CappedTag<std::uint8_t, 64> d;
    const auto zero = hn::Zero(d);
    const std::size_t lanes = hn::Lanes(d),
                      bottom = std::min(size, static_cast<std::size_t>(extent.bottom) + 2);
    for (std::size_t k = left & ~(lanes - 1); k < right; k += lanes) {
        auto layers = hn::Set(d, static_cast<std::uint8_t>(at_pole));
        std::uint8_t *from = counters + top * stride + k, *to = blocked + top * size + k / 8;
        for (std::size_t r = top; r < bottom; ++r, from += stride, to += size) {
            layers = hn::Add(layers, hn::Load(d, from));
            hn::Store(zero, d, from);
            hn::StoreMaskBits(d, hn::Ne(layers, zero), to);
        }
        hn::Store(zero, d, from);  // crossings below the last row that is wanted
        std::uint8_t last[8] = {};
        hn::StoreMaskBits(d, hn::Ne(layers, zero), last);
        for (std::size_t r = bottom; r < size; ++r, to += size) std::memcpy(to, last, lanes / 8);
    }
#endif
}

/// The most layers that begin along any sub-column of a face.
int most_beginning(const VisibleContour& contour, int face, int face_size, ContourScratch& scratch) {
    std::vector<int> beginning(std::size_t(samples_per_texel * face_size) + 1, 0);
    const std::size_t edge_count = edges_of_face(contour, face, scratch.of_face.data());
    for (std::size_t first = 0; first < edge_count; first += line_queue_length) {
        const std::size_t count = std::min(line_queue_length, edge_count - first);
        ContourExtent extent;
        const float* lines = scratch.lines.data();
        fill_queue(contour, scratch.of_face.data() + first, count, scratch.queue.data());
        set_up_lines(scratch.queue.data(), count, face, face_size, scratch.lines.data(), extent);
        for (std::size_t i = 0; i < count; ++i) {
            const auto data = [&](LineData k) { return static_cast<int>(lines[k * line_queue_length + i]); };
            const int change = std::max(0, data(line_change));
            beginning[std::size_t(data(line_begin))] += change;
            beginning[std::size_t(data(line_end))] -= change;
        }
    }
    std::partial_sum(beginning.begin(), beginning.end(), beginning.begin());
    return *std::max_element(beginning.begin(), beginning.end());
}

/// Draws the edges of a face; returns what they change.
ContourExtent count_changes(const VisibleContour& contour, int face, int face_size, ContourScratch& scratch) {
    ContourExtent extent;
    const std::uint32_t* edges = scratch.of_face.data();
    const std::size_t edge_count = edges_of_face(contour, face, scratch.of_face.data());
    std::uint8_t* counters = scratch.counters.data();
    const std::uint32_t* crossings = scratch.crossings.data();
    const std::uint8_t* changes = scratch.changes.data();
    for (std::size_t first = 0; first < edge_count; first += line_queue_length) {
        const std::size_t count = std::min(line_queue_length, edge_count - first);
        fill_queue(contour, edges + first, count, scratch.queue.data());
        set_up_lines(scratch.queue.data(), count, face, face_size, scratch.lines.data(), extent);
        const std::size_t listed = list_crossings(scratch.lines.data(), count, face_size, scratch);
        for (std::size_t i = 0; i < listed; ++i) {
            std::uint8_t& counter = counters[crossings[i] - float_offset_bits];
            counter = static_cast<std::uint8_t>(counter + changes[i]);
        }
    }
    return extent;
}

bool block_contour(const Occluder& occluder, const ViewedOccluder& viewed, const VisibleContour& contour,
                   ContourScratch& scratch, BlockedSamples& blocked) {
    const int face_size = blocked.face_size;
    int poles[3][2] = {{-1, -1}, {-1, -1}, {-1, -1}};
    for (int face = 0; face < cubemap_faces; ++face) {
        const int axis = all_face_components[face].component[1];
        const bool is_upwards = all_face_components[face].sign[1] < 0;  // the pole is at -v
        int& at_pole = poles[axis][is_upwards];
        if (at_pole < 0)
            at_pole = layers_along_axis(occluder, viewed, contour.facing.data(), axis, is_upwards);
        using Contours = BlockedSamples::Contours;
        Contours& contours = blocked.contoured_faces[std::size_t(face)];
        const ContourExtent extent = count_changes(contour, face, face_size, scratch);
        if (!(extent.left < extent.right)) {
            contours = at_pole > 0 ? Contours::block_all : Contours::block_nothing;
            continue;
        }
        sum_layers(face_size, at_pole, extent, scratch.counters.data(), blocked.texels(face));
        contours = Contours::vary;
        if (static_cast<float>(at_pole) + extent.beginning > most_layers &&
            at_pole + most_beginning(contour, face, face_size, scratch) > most_layers) {
            blocked.contoured_faces.fill(Contours::block_nothing);
            return false;
        }
    }
    return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(block_contour);

bool block_contour(const Occluder& occluder, const ViewedOccluder& viewed, const VisibleContour& contour,
                   ContourScratch& scratch, BlockedSamples& blocked) {
    const auto size = static_cast<std::size_t>(blocked.face_size), stride = samples_per_texel * size;
    constexpr std::size_t widest_vector = 16;
    if (size < 8) return false;
    if (scratch.columns.data() == nullptr) fill_columns(blocked.face_size, scratch.columns);
    scratch.of_face.reserve(contour.count);
    scratch.queue.reserve((2 * 4 + 1) * line_queue_length);
    scratch.lines.reserve(line_data_count * line_queue_length);
    scratch.crossings.reserve(line_queue_length * stride + widest_vector);
    scratch.changes.reserve(line_queue_length * stride + widest_vector);
    scratch.counters.reserve((size + 1) * stride);
    return HWY_DYNAMIC_DISPATCH(block_contour)(occluder, viewed, contour, scratch, blocked);
}

}  // namespace haarfield
#endif
