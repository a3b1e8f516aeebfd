#include "fields/rasterizer/span_rasterizer.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numeric>

#include "fields/rasterizer/face_outcodes.h"
#include "fields/rasterizer/sample_pattern.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/rasterizer/span_rasterizer.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fields/rasterizer/edge_lines-inl.h"

#ifndef HAARFIELD_SPAN_RASTERIZER_ONCE
#define HAARFIELD_SPAN_RASTERIZER_ONCE

namespace haarfield {

/// Returns the bits of a word that are numbered from `start` and below `end`.
constexpr std::uint64_t bits_below(std::uint32_t end, std::uint32_t start) {
    if (end <= start) return 0;
    return end - start >= 64 ? ~std::uint64_t(0) : (std::uint64_t(1) << (end - start)) - 1;
}

/// The faces that a triangle may touch, indexed by the outcode bits that all its vertices share.
struct FacesByOutcode {
    std::array<std::uint8_t, 4096> faces{};
    FacesByOutcode() {
        for (unsigned common = 0; common < faces.size(); ++common)
            for (unsigned face = 0; face < cubemap_faces; ++face)
                if ((common & (outside_left_or_right(int(face)) | outside_above(int(face)) |
                               outside_below(int(face)))) == 0)
                    faces[common] |= static_cast<std::uint8_t>(1u << face);
    }
};
inline const FacesByOutcode faces_by_outcode;

/// Triangles are queued per face to fill whole vectors.
inline constexpr std::size_t queue_length = 64;
inline constexpr std::size_t queue_floats = queue_length * 4;  ///< Floats of one of the three vertices.

/// The data of queued triangles for drawing. Structure of arrays, each queue_length floats long.
enum EdgeData : std::size_t {
    edge_slope,      ///< Three of them: the side is at row  slope * c + constant  at column c.
    edge_lower = 3,  ///< Constants of the three sides if the rows are below them (larger v), or -huge.
    edge_upper = 6,  ///< Constants of the three sides if the rows are above them, or +huge.
    edge_begin = 9,  ///< Sub-columns [begin, end).
    edge_end = 10,
    edge_top = 11,  ///< Rows that contain the triangle, with a margin for rounding.
    edge_bottom = 12,
    edge_data_count = 13
};

/// Triangles are drawn from near to far if there are at least this many.
inline constexpr std::size_t fewest_sorted = 256;
inline constexpr int ranges = 64;  ///< Of distances: four per doubling of the squared distance.

/// Sorts triangles by their range of distances, in linear time.
inline void sort_by_range(std::vector<DrawnTriangle>& triangles, std::vector<DrawnTriangle>& sorted) {
    std::array<std::size_t, ranges> place{};
    for (const DrawnTriangle& triangle : triangles) ++place[triangle.range];
    std::exclusive_scan(place.begin(), place.end(), place.begin(), std::size_t(0));
    sorted.resize(triangles.size());
    for (const DrawnTriangle& triangle : triangles) sorted[place[triangle.range]++] = triangle;
    triangles.swap(sorted);
}

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

using Words = hn::CappedTag<std::uint64_t, 8>;

// A direction d lies in the cone of the triangle (a, b, c), viewed from the origin, iff d = αa + βb + γc with
// α, β, γ >= 0. These are three half-spaces through the origin, whose normals are cross products of two
// vertices. No clipping is needed, wherever the vertices are. Neighbours compute the same crossing of their
// common side with a sub-column, so every sample is on one side or on both.
HWY_INLINE void set_up_side(const FaceVertices& p, const FaceVertices& q, int face_size, float* edges,
                            std::size_t k) {
    const Floats d;
    const EdgeLine line = edge_line(p, q, face_size);
    const auto is_upper = hn::And(line.crosses, hn::Lt(line.turn, hn::Zero(d)));
    hn::StoreU(line.slope, d, edges + (edge_slope + k) * queue_length);
    hn::StoreU(hn::IfThenElse(is_upper, hn::Set(d, -1e30f), line.constant), d,
               edges + (edge_lower + k) * queue_length);
    hn::StoreU(hn::IfThenElse(is_upper, line.constant, hn::Set(d, 1e30f)), d,
               edges + (edge_upper + k) * queue_length);
}

/// Returns the texel row of a vertex with w > 0, from the top.
HWY_INLINE VF row_of(const FaceVertices& vertex, VF half) {
    return hn::Add(hn::Mul(hn::Div(vertex.v, vertex.w), half), half);
}

void set_up(const float* queue, std::size_t count, int face, int face_size, float* edges) {
    const Floats d;
    const FaceComponents frame = all_face_components[face];
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const FaceVertices a = load_vertices(queue + 4 * i, frame),
                           b = load_vertices(queue + queue_floats + 4 * i, frame),
                           c = load_vertices(queue + 2 * queue_floats + 4 * i, frame);
        // A front-facing triangle is counter-clockwise, so the normals of (b, a), (c, b) and (a, c) point
        // inwards.
        set_up_side(b, a, face_size, edges + i, 0);
        set_up_side(c, b, face_size, edges + i, 1);
        set_up_side(a, c, face_size, edges + i, 2);

        const VF left_of_a = sub_columns_left_of(a, face_size), left_of_b = sub_columns_left_of(b, face_size),
                 left_of_c = sub_columns_left_of(c, face_size);
        // If a vertex is behind, the vertices do not bound the projection.
        const auto bounded = hn::Gt(hn::Min(a.w, hn::Min(b.w, c.w)), hn::Zero(d));
        const VF columns = hn::Set(d, static_cast<float>(samples_per_texel * face_size));
        const VF half = hn::Set(d, 0.5f * static_cast<float>(face_size));
        const VF row_of_a = row_of(a, half), row_of_b = row_of(b, half), row_of_c = row_of(c, half);
        hn::StoreU(hn::IfThenElseZero(bounded, hn::Min(left_of_a, hn::Min(left_of_b, left_of_c))), d,
                   edges + edge_begin * queue_length + i);
        hn::StoreU(hn::IfThenElse(bounded, hn::Max(left_of_a, hn::Max(left_of_b, left_of_c)), columns), d,
                   edges + edge_end * queue_length + i);
        const VF margin = hn::Set(d, 0.05f);
        hn::StoreU(hn::IfThenElse(bounded, hn::Sub(hn::Min(row_of_a, hn::Min(row_of_b, row_of_c)), margin),
                                  hn::Set(d, -1.0f)),
                   d, edges + edge_top * queue_length + i);
        hn::StoreU(hn::IfThenElse(bounded, hn::Add(hn::Max(row_of_a, hn::Max(row_of_b, row_of_c)), margin),
                                  hn::Add(half, half)),
                   d, edges + edge_bottom * queue_length + i);
    }
}

/// Tests whether all samples of some rows are blocked in the sub-columns [begin, end).
///
/// rows  one bit per row.
HWY_INLINE bool are_blocked(const std::uint64_t* strip, std::size_t begin, std::size_t end,
                            std::uint64_t rows) {
    const Words d;
    const auto wanted = hn::Set(d, rows);
    std::size_t k = begin;
    for (; k + hn::Lanes(d) <= end; k += hn::Lanes(d))
        if (!hn::AllTrue(d, hn::Eq(hn::And(hn::LoadU(d, strip + k), wanted), wanted))) return false;
    for (; k < end; ++k)
        if ((strip[k] & rows) != rows) return false;
    return true;
}

/// Returns the bits of the rows of a strip that a triangle may cover.
///
/// top, bottom  of the triangle, relative to the strip. [rows]
/// count        rows of the strip, 1 to 64.
inline std::uint64_t rows_between(float top, float bottom, float count) {
    // The sample of row r is between r and r + 1.
    const auto first = static_cast<unsigned>(std::min(std::max(std::floor(top), 0.0f), count)),
               end = static_cast<unsigned>(std::min(std::max(std::floor(bottom) + 1, 0.0f), count));
    return bits_below(end, first) << (first & 63);
}

/// Returns a word with all bits from bit n on set, 0 <= n <= 64.
template <class DU>
HWY_INLINE hn::Vec<DU> bits_from(DU d, hn::Vec<DU> n) {
    const auto ones = hn::Set(d, ~std::uint64_t(0));
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
    return hn::Shl(ones, n);  // here a shift by 64 yields 0
#else
    const auto rest = hn::And(n, hn::Set(d, 63));
    return hn::IfThenElseZero(hn::Eq(rest, n), hn::Shl(ones, rest));
#endif
}

/// Blocks the rows [begin, end) in one sub-column per lane.
template <class VU>
HWY_INLINE void block_rows(VU begin, VU end, std::uint64_t* words) {
    const Words d;
#if HWY_TARGET == HWY_SCALAR
    const auto rows = hn::AndNot(bits_from(d, hn::PromoteTo(d, end)), bits_from(d, hn::PromoteTo(d, begin)));
    hn::Store(hn::Or(hn::Load(d, words), rows), d, words);
#else
    const hn::Half<hn::DFromV<VU> > half;
    const auto low = hn::AndNot(bits_from(d, hn::PromoteTo(d, hn::LowerHalf(half, end))),
                                bits_from(d, hn::PromoteTo(d, hn::LowerHalf(half, begin))));
    hn::Store(hn::Or(hn::Load(d, words), low), d, words);
    words += hn::Lanes(d);
    const auto high = hn::AndNot(bits_from(d, hn::PromoteTo(d, hn::UpperHalf(half, end))),
                                 bits_from(d, hn::PromoteTo(d, hn::UpperHalf(half, begin))));
    hn::Store(hn::Or(hn::Load(d, words), high), d, words);
#endif
}

void draw(const float* edges, std::size_t count, int face_size, std::uint64_t* strip, int first_row) {
    const Floats d;
    const hn::RebindToSigned<Floats> di;
    const hn::RebindToUnsigned<Floats> du;
    const std::size_t lanes = hn::Lanes(d);
    const VF zero = hn::Zero(d), minus_one = hn::Set(d, -1.0f);
    const VF rows = hn::Set(d, static_cast<float>(std::min(face_size - first_row, 64)));
    const VF last_row = hn::Sub(rows, hn::Set(d, 1.0f));
    const float base = 0.5f / samples_per_texel - 0.5f * static_cast<float>(face_size);
    const VF lane = hn::Iota(d, 0), steps = hn::Mul(lane, hn::Set(d, 1.0f / samples_per_texel));
    for (std::size_t i = 0; i < count; ++i) {
        const auto data = [&](std::size_t k) { return edges[k * queue_length + i]; };
        const auto column_begin = static_cast<std::size_t>(data(edge_begin)),
                   column_end = static_cast<std::size_t>(data(edge_end));
        if (column_begin >= column_end) continue;
        const float top = data(edge_top) - static_cast<float>(first_row),
                    bottom = data(edge_bottom) - static_cast<float>(first_row);
        const std::uint64_t reached = rows_between(top, bottom, hn::GetLane(rows));
        if (are_blocked(strip, column_begin, column_end, reached)) continue;
        const VF columns_begin = hn::Set(d, data(edge_begin)), columns_end = hn::Set(d, data(edge_end));
        const VF slope0 = hn::Set(d, data(0)), slope1 = hn::Set(d, data(1)), slope2 = hn::Set(d, data(2));
        const VF lower0 = hn::Set(d, data(3)), lower1 = hn::Set(d, data(4)), lower2 = hn::Set(d, data(5));
        const VF upper0 = hn::Set(d, data(6)), upper1 = hn::Set(d, data(7)), upper2 = hn::Set(d, data(8));
        for (std::size_t k = column_begin & ~(lanes - 1); k < column_end; k += lanes) {
            const VF column =
                hn::Add(steps, hn::Set(d, static_cast<float>(k) * (1.0f / samples_per_texel) + base));
            const VF line0 = hn::Mul(slope0, column), line1 = hn::Mul(slope1, column),
                     line2 = hn::Mul(slope2, column);
            const VF offset = hn::Add(hn::LoadU(d, row_offsets.rows.data() + (k & 7)),
                                      hn::Set(d, static_cast<float>(first_row)));
            const VF from = hn::Sub(
                hn::Max(hn::Max(hn::Add(line0, lower0), hn::Add(line1, lower1)), hn::Add(line2, lower2)),
                offset);
            const VF to = hn::Sub(
                hn::Min(hn::Min(hn::Add(line0, upper0), hn::Add(line1, upper1)), hn::Add(line2, upper2)),
                offset);
            const VF number = hn::Add(lane, hn::Set(d, static_cast<float>(k)));
            const auto within = hn::And(hn::Ge(number, columns_begin), hn::Lt(number, columns_end));
            const auto begin =
                hn::BitCast(du, hn::ConvertTo(di, hn::Ceil(hn::Min(hn::Max(from, zero), rows))));
            const auto end = hn::BitCast(
                du, hn::Add(hn::ConvertTo(di, hn::Floor(hn::Min(
                                                  hn::Max(hn::IfThenElse(within, to, minus_one), minus_one),
                                                  last_row))),
                            hn::Set(di, 1)));
            block_rows(begin, end, strip + k);
        }
    }
}

void block_queue(SpanScratch& scratch, std::size_t count, int face, BlockedSamples& blocked) {
    float* edges = scratch.edges.data();
    set_up(scratch.queue.data() + std::size_t(face) * 3 * queue_floats, count, face, blocked.face_size,
           edges);
    for (int s = 0; s < int(blocked.strips); ++s)
        draw(edges, count, blocked.face_size, blocked.strip(face, s), 64 * s);
    blocked.spanned_faces |= 1u << face;
}

/// Transforms one vector of vertices. `first` is a multiple of its length.
void view_vertices(const Occluder& occluder, const ViewedOccluder& viewed, std::size_t first,
                   float* vertices) {
    const Floats d;
    const Codes di;
    const ViewedVertices v = load_viewed_vertices(occluder.padded_positions().data() + 4 * first, viewed);
    VC code = common_outcodes(v, v);
    if (viewed.horizon) {
        const auto below = hn::Le(height_over_view_point(v, viewed.up), hn::Set(d, viewed.lowest));
        code = hn::Or(code, hn::IfThenElseZero(hn::RebindMask(di, below), hn::Set(di, below_horizon)));
    }
    hn::StoreInterleaved4(v.x, v.y, v.z, hn::BitCast(d, code), d, vertices + 4 * first);
}

void block_spans(const Occluder& occluder, const ViewedOccluder& viewed, const std::uint64_t* chosen,
                 SpanScratch& scratch, BlockedSamples& blocked) {
    const Floats d;
    const std::size_t lanes = hn::Lanes(d), vertex_count = occluder.positions().size();
    const auto count = static_cast<std::uint32_t>(occluder.triangles().size());
    scratch.vertices.reserve(4 * (vertex_count + 16));
    scratch.viewed_vectors.reserve(vertex_count / lanes + 1);
    scratch.queue.reserve(cubemap_faces * 3 * queue_floats);
    scratch.edges.reserve(edge_data_count * queue_length);
    float* vertices = scratch.vertices.data();
    std::uint8_t* viewed_vectors = scratch.viewed_vectors.data();
    std::fill_n(viewed_vectors, vertex_count / lanes + 1, std::uint8_t(0));
    scratch.drawn.clear();
    std::size_t queued[cubemap_faces] = {};
    // The exponent and two bits of the mantissa of a squared distance.
    const auto code = [](float squared) { return int(std::bit_cast<std::uint32_t>(squared) >> 21); };
    const float farthest = viewed.from_centre.length() + occluder.bounds().radius();
    const int last_code = code(farthest * farthest);
    const auto range_of = [&](const float* vertex) {
        const float squared = vertex[0] * vertex[0] + vertex[1] * vertex[1] + vertex[2] * vertex[2];
        return static_cast<std::uint8_t>(std::clamp(ranges - 1 + code(squared) - last_code, 0, ranges - 1));
    };
    const auto block = [&](std::uint32_t t, bool front) {
        const auto& [i, j, k] = occluder.triangles()[t];
        const float *a = vertices + 4 * std::size_t(i), *b = vertices + 4 * std::size_t(front ? j : k),
                    *c = vertices + 4 * std::size_t(front ? k : j);
        const unsigned common =
            std::bit_cast<unsigned>(a[3]) & std::bit_cast<unsigned>(b[3]) & std::bit_cast<unsigned>(c[3]);
        if (common & below_horizon) return;
        for (unsigned faces = faces_by_outcode.faces[common]; faces != 0; faces &= faces - 1) {
            const int face = std::countr_zero(faces);
            float* to = scratch.queue.data() + std::size_t(face) * 3 * queue_floats + 4 * queued[face];
            std::memcpy(to, a, 16);
            std::memcpy(to + queue_floats, b, 16);
            std::memcpy(to + 2 * queue_floats, c, 16);
            if (++queued[face] == queue_length) {
                block_queue(scratch, queue_length, face, blocked);
                queued[face] = 0;
            }
        }
    };
    for (std::uint32_t start = 0; start < count; start += 64) {
        if (chosen[start / 64] == 0) continue;
        std::uint64_t front = 0, back = 0;
        for (std::size_t i = 0; i < 64; i += lanes) {
            const OccluderPlanes& of = occluder.planes();
            const std::size_t t = start + i;
            const VF heights = heights_over_planes(d, of.x.data() + t, of.y.data() + t, of.z.data() + t,
                                                   of.offset.data() + t, viewed.from_centre);
            front |= bits_of(d, hn::Gt(heights, hn::Zero(d))) << i;
            back |= bits_of(d, hn::Lt(heights, hn::Zero(d))) << i;
        }
        const std::uint64_t two_sided = ~bits_below(occluder.one_sided(), start);
        for (std::uint64_t drawn = (front | (back & two_sided)) & chosen[start / 64]; drawn != 0;
             drawn &= drawn - 1) {
            const int i = std::countr_zero(drawn);
            const std::uint32_t t = start + static_cast<std::uint32_t>(i);
            for (const std::uint32_t v : occluder.triangles()[t])
                if (std::uint8_t& is_viewed = viewed_vectors[v / lanes]; !is_viewed) {
                    view_vertices(occluder, viewed, v / lanes * lanes, vertices);
                    is_viewed = 1;
                }
            scratch.drawn.push_back(
                {t, (front >> i & 1) != 0, range_of(vertices + 4 * std::size_t(occluder.triangles()[t][0]))});
        }
    }
    // Then nearer triangles often block all samples of a triangle, which `draw` skips.
    if (scratch.drawn.size() >= fewest_sorted) sort_by_range(scratch.drawn, scratch.sorted);
    for (const DrawnTriangle& triangle : scratch.drawn) block(triangle.number, triangle.front);
    for (int face = 0; face < cubemap_faces; ++face)
        if (queued[face] != 0) block_queue(scratch, queued[face], face, blocked);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(block_spans);

void block_spans(const Occluder& occluder, const ViewedOccluder& viewed, const std::uint64_t* chosen,
                 SpanScratch& scratch, BlockedSamples& blocked) {
    HWY_DYNAMIC_DISPATCH(block_spans)(occluder, viewed, chosen, scratch, blocked);
}

}  // namespace haarfield
#endif
