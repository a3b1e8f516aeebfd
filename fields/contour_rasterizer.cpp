#include "fields/contour_rasterizer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "fields/view_frame.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/contour_rasterizer.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// The number of front-facing layers along a ray grows and falls by one where the ray's direction crosses the
// image of a contour edge, that is, of an edge between a triangle that counts (seen from the front, not below
// the horizon) and one that does not: on the common edge of two that count, one is entered as the other is
// left. So each sub-column of a face is followed from the pole of all sub-columns, the direction -down, where
// the layers are counted once; each contour edge changes the number by one where it crosses the sub-column.
//
// Which sub-columns an edge crosses follows from its ends alone, so that the edges of a closed contour always
// agree about it. An edge with one end behind the face's plane w = 0 leaves by one of the poles; by which
// side of them the sign of its normal tells, which is the sign that counting the layers at the pole goes by.
// If the pole is so close to an edge that the sign is in doubt, we give up.

#ifndef HAARFIELD_CONTOUR_RASTERIZER_ONCE
#define HAARFIELD_CONTOUR_RASTERIZER_ONCE

namespace haarfield {

inline constexpr std::size_t line_queue_length = 64;
inline constexpr std::size_t most_layers = 255;

/// What drawing needs of each edge in the queue: SoA, line_queue_length floats each. Rows and sub-columns are
/// counted from 0; the edge crosses the sub-columns [begin, end) at row  slope * c + constant,  clamped.
enum LineData : std::size_t {
    line_slope,
    line_constant,
    line_lowest,
    line_highest,
    line_begin,
    line_end,
    line_enters,  ///< 1: downwards a layer begins here; 0: one ends.
    line_data_count
};

/// Relative rounding error of a component of a cross product, with room to spare.
inline constexpr float sign_doubt = 1e-6f;

/// The front-facing triangles, without those below the horizon.
inline void counting_triangles(const Occluder& occluder, const ViewedOccluder& viewed,
                               std::vector<std::uint64_t>& front) {
    const float* vertices = viewed.vertices.data();
    const std::size_t words = occluder.one_sided_edges.clusters.size();
    front.resize(words);
    for (std::size_t w = 0; w < words; ++w) {
        std::uint64_t word =
            viewed.facing.data()[2 * w] & bits_below(occluder.one_sided, static_cast<std::uint32_t>(64 * w));
        for (std::uint64_t rest = viewed.horizon ? word : 0; rest != 0; rest &= rest - 1) {
            const auto& t = occluder.triangles[64 * w + std::size_t(std::countr_zero(rest))];
            if (common_outcode(vertices, t) & below_horizon) word &= ~(rest & -rest);
        }
        front[w] = word;
    }
}

/// Copies the contour edges, directed as in the triangle that counts. Returns how many.
inline std::size_t contour_edges(const Occluder& occluder, const ViewedOccluder& viewed,
                                 ContourScratch& scratch) {
    const OccluderEdges& all = occluder.one_sided_edges;
    const std::uint64_t* front = scratch.front.data();
    scratch.contour.resize(all.edges.size());
    std::uint32_t* to = scratch.contour.data();
    const auto counts = [&](std::uint32_t t) {
        return static_cast<std::uint32_t>(front[t / 64] >> (t % 64)) & 1u;
    };
    // Few are: no branch to guess wrong.
    const auto test = [&](std::uint32_t first, std::uint32_t last) {
        for (std::uint32_t e = first; e < last; ++e) {
            *to = e;
            to += counts(all.edges[e].forward) ^ counts(all.edges[e].backward);
        }
    };
    for (std::size_t w = 0; w < scratch.front.size(); ++w)
        if (front[w] != 0 && front[w] != ~std::uint64_t(0)) test(all.first[w], all.first[w + 1]);
    // One past the last edge nothing is written: to has got no further than e.
    test(all.first.back(), static_cast<std::uint32_t>(all.edges.size()));

    const auto found = static_cast<std::size_t>(to - scratch.contour.data());
    scratch.edges.reserve(8 * found);
    float* ends = scratch.edges.data();
    for (std::size_t i = 0; i < found; ++i, ends += 8) {
        const OccluderEdge& edge = all.edges[scratch.contour[i]];
        const bool forward = counts(edge.forward) != 0;
        std::memcpy(ends, viewed.vertices.data() + 4 * std::size_t(forward ? edge.low : edge.high), 16);
        std::memcpy(ends + 4, viewed.vertices.data() + 4 * std::size_t(forward ? edge.high : edge.low), 16);
    }
    return found;
}

/// Layers in the direction of an axis; -1 if it comes too close to an edge.
inline int layers_along(const Occluder& occluder, const ViewedOccluder& viewed, const Vec3f& view_point,
                        const std::vector<std::uint64_t>& front, int axis, float sign) {
    const int across = (axis + 1) % 3, up = (axis + 2) % 3;
    const float margin = 1e-5f * occluder.bounds.radius();
    const float* vertices = viewed.vertices.data();
    int layers = 0;
    for (std::size_t w = 0; w < front.size(); ++w) {
        const Bounds& box = occluder.one_sided_edges.clusters[w];
        if (front[w] == 0 || view_point[across] < box.lower[across] - margin ||
            view_point[across] > box.upper[across] + margin || view_point[up] < box.lower[up] - margin ||
            view_point[up] > box.upper[up] + margin)
            continue;
        if (sign > 0 ? box.upper[axis] < view_point[axis] - margin
                     : box.lower[axis] > view_point[axis] + margin)
            continue;
        for (std::uint64_t rest = front[w]; rest != 0; rest &= rest - 1) {
            const auto& t = occluder.triangles[64 * w + std::size_t(std::countr_zero(rest))];
            bool within = true, doubt = false;
            for (std::size_t k = 0; k < 3 && within; ++k) {
                const float *p = vertices + 4 * std::size_t(t[k]),
                            *q = vertices + 4 * std::size_t(t[(k + 1) % 3]);
                const float a = (p[across] + q[across]) * (q[up] - p[up]),
                            b = (p[up] + q[up]) * (q[across] - p[across]);
                const float inwards = (b - a) * sign, uncertain = sign_doubt * (std::abs(a) + std::abs(b));
                if (inwards < -uncertain) within = false;
                if (!(inwards > uncertain)) doubt = true;
            }
            if (!within) continue;
            if (doubt) return -1;
            ++layers;
        }
    }
    return layers;
}

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;
using VF = hn::Vec<Floats>;

struct LineEnds {
    VF u, v, w;
};

HWY_INLINE LineEnds load_ends(const float* from, const FaceComponents& frame) {
    const Floats d;
    VF x, y, z, code;
    hn::LoadInterleaved4(d, from, x, y, z, code);
    const auto component = [&](int i) {
        const VF chosen = frame.component[i] == 0 ? x : frame.component[i] == 1 ? y : z;
        return hn::Mul(chosen, hn::Set(d, frame.sign[i]));
    };
    return {component(0), component(1), component(2)};
}

/// The lines of the queue's edges on a face. The arithmetic of slope and constant is that of the span
/// rasterizer, to the bit. False if any edge leaves so close to the pole that it may pass on either side.
bool set_up_lines(const float* queue, std::size_t count, int face, int face_size, float* lines) {
    const Floats d;
    const FaceComponents frame = all_face_components[face];
    const VF zero = hn::Zero(d), one = hn::Set(d, 1.0f),
             half = hn::Set(d, 0.5f * static_cast<float>(face_size));
    const VF per_unit = hn::Set(d, 4.0f * static_cast<float>(face_size)),
             columns = hn::Set(d, 8.0f * static_cast<float>(face_size));
    bool certain = true;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const LineEnds p = load_ends(queue + 4 * i, frame),
                       q = load_ends(queue + 4 * line_queue_length + 4 * i, frame);
        const VF su = hn::Add(p.u, q.u), sv = hn::Add(p.v, q.v), sw = hn::Add(p.w, q.w);
        const VF du = hn::Sub(q.u, p.u), dv = hn::Sub(q.v, p.v), dw = hn::Sub(q.w, p.w);
        const VF nu = hn::Sub(hn::Mul(sv, dw), hn::Mul(sw, dv));
        const VF first = hn::Mul(sw, du), second = hn::Mul(su, dw), nv = hn::Sub(first, second);
        const VF nw = hn::Sub(hn::Mul(su, dv), hn::Mul(sv, du));
        const VF largest = hn::Max(hn::Max(hn::Abs(nu), hn::Abs(nw)), hn::Set(d, 1e-20f));
        const auto crosses = hn::Gt(hn::Abs(nv), hn::Mul(largest, hn::Set(d, 0x1p-30f)));
        const VF scale = hn::Neg(
            hn::Div(hn::IfThenElse(crosses, one, hn::Set(d, 0x1p40f)), hn::IfThenElse(crosses, nv, largest)));
        const VF slope = hn::Mul(nu, scale);
        const VF constant = hn::Add(hn::Mul(half, hn::Mul(nw, scale)), half);

        // An end's place among the sub-columns: how many lie left of it.
        const auto place = [&](const LineEnds& end) {
            const VF at = hn::Sub(hn::Mul(hn::Add(hn::Div(end.u, end.w), one), per_unit), hn::Set(d, 0.5f));
            return hn::Ceil(hn::Min(hn::Max(at, zero), columns));
        };
        const VF at_p = place(p), at_q = place(q);
        const auto p_ahead = hn::Gt(p.w, zero), q_ahead = hn::Gt(q.w, zero);
        const auto both = hn::And(p_ahead, q_ahead), either = hn::Or(p_ahead, q_ahead);
        // Rightwards: from p to q the edge runs to larger u, with its triangle above, at smaller v.
        const auto rightwards = hn::Or(hn::And(both, hn::Lt(at_p, at_q)), hn::AndNot(both, hn::Gt(nv, zero)));
        // An edge that ends behind runs to the left or right end of all sub-columns.
        const VF from = hn::IfThenElse(p_ahead, at_p, hn::IfThenElse(rightwards, zero, columns)),
                 to = hn::IfThenElse(q_ahead, at_q, hn::IfThenElse(rightwards, columns, zero));
        VF begin = hn::Min(from, to), end = hn::IfThenElse(either, hn::Max(from, to), begin);

        const auto straddles = hn::AndNot(both, either);
        const auto doubtful = hn::And(
            straddles,
            hn::Le(hn::Abs(nv), hn::Mul(hn::Set(d, sign_doubt), hn::Add(hn::Abs(first), hn::Abs(second)))));
        // By the pole below, all of its crossings are out of sight. v where w = 0, but for a positive factor:
        const VF leaves_at = hn::IfThenElse(p_ahead, hn::Sub(hn::Mul(q.v, p.w), hn::Mul(p.v, q.w)),
                                            hn::Sub(hn::Mul(p.v, q.w), hn::Mul(q.v, p.w)));
        end = hn::IfThenElse(doubtful, begin, end);
        std::uint8_t mask[8] = {};
        hn::StoreMaskBits(d, hn::And(doubtful, hn::Not(hn::Gt(leaves_at, zero))), mask);
        std::uint64_t bits;
        std::memcpy(&bits, mask, sizeof bits);
        if ((bits & bits_below(static_cast<std::uint32_t>(count - i), 0)) != 0) certain = false;

        // Between its ends, with room for rounding.
        const VF row_p = hn::Mul(hn::Add(hn::Div(p.v, p.w), one), half),
                 row_q = hn::Mul(hn::Add(hn::Div(q.v, q.w), one), half), slack = hn::Set(d, 0.01f);
        const VF far = hn::Set(d, 1e9f);
        const auto store = [&](LineData k, VF value) {
            hn::StoreU(value, d, lines + k * line_queue_length + i);
        };
        store(line_slope, slope);
        store(line_constant, constant);
        store(line_lowest, hn::IfThenElse(both, hn::Sub(hn::Min(row_p, row_q), slack), hn::Neg(far)));
        store(line_highest, hn::IfThenElse(both, hn::Add(hn::Max(row_p, row_q), slack), far));
        store(line_begin, begin);
        store(line_end, end);
        store(line_enters, hn::IfThenElse(rightwards, zero, one));
    }
    return certain;
}

void draw_lines(const float* lines, std::size_t count, int face_size, ContourScratch& scratch) {
    const Floats d;
    const hn::RebindToSigned<Floats> di;
    const std::size_t lanes = hn::Lanes(d);
    const auto stride = static_cast<std::int32_t>(samples_per_texel * face_size);
    std::uint8_t* counters = scratch.counters.data();
    const VF rows = hn::Set(d, static_cast<float>(face_size));
    const VF steps = hn::Mul(hn::Iota(d, 0), hn::Set(d, 1.0f / samples_per_texel));
    const float base = 0.5f / samples_per_texel - 0.5f * static_cast<float>(face_size);
    for (std::size_t i = 0; i < count; ++i) {
        const auto data = [&](LineData k) { return lines[k * line_queue_length + i]; };
        const auto begin = static_cast<std::size_t>(data(line_begin)),
                   end = static_cast<std::size_t>(data(line_end));
        if (begin >= end) continue;
        const bool enters = data(line_enters) != 0;
        if (enters) {
            ++scratch.entering[begin];
            --scratch.entering[end];
        }
        const auto change = static_cast<std::uint8_t>(enters ? 1 : -1);
        const VF slope = hn::Set(d, data(line_slope)), constant = hn::Set(d, data(line_constant));
        const VF lowest = hn::Set(d, data(line_lowest)), highest = hn::Set(d, data(line_highest));
        for (std::size_t k = begin; k < end; k += lanes) {
            const VF column =
                hn::Add(steps, hn::Set(d, static_cast<float>(k) * (1.0f / samples_per_texel) + base));
            const VF line = hn::Min(hn::Max(hn::Add(hn::Mul(slope, column), constant), lowest), highest);
            const VF row = hn::Sub(line, hn::LoadU(d, row_offsets.rows.data() + (k & 7)));
            // The first sample that is entered, or the first that is left: a sample on the edge is blocked.
            const VF changed = enters ? hn::Ceil(hn::Max(row, hn::Zero(d)))
                                      : hn::Add(hn::Floor(hn::Max(row, hn::Set(d, -1.0f))), hn::Set(d, 1.0f));
            alignas(64) std::int32_t at[16];
            hn::Store(hn::ConvertTo(di, hn::Min(changed, rows)), di, at);
            std::uint8_t* sub_columns = counters + k;
            const std::size_t here = std::min(lanes, end - k);
            for (std::size_t j = 0; j < here; ++j) {
                std::uint8_t& counter = sub_columns[at[j] * stride + static_cast<std::int32_t>(j)];
                counter = static_cast<std::uint8_t>(counter + change);
            }
        }
    }
}

/// Adds the counters up, from the first row to the last, and clears them.
void sum_layers(int face_size, int at_pole, ContourScratch& scratch) {
    const auto size = static_cast<std::size_t>(face_size), stride = samples_per_texel * size;
    std::uint8_t* counters = scratch.counters.data();
    std::uint8_t* blocked = scratch.blocked.data();
#if HWY_TARGET == HWY_SCALAR
    for (std::size_t k = 0; k < stride; ++k) {
        auto layers = static_cast<std::uint8_t>(at_pole);
        for (std::size_t r = 0; r < size; ++r) {
            layers = static_cast<std::uint8_t>(layers + counters[r * stride + k]);
            std::uint8_t& bits = blocked[r * size + k / 8];
            bits = static_cast<std::uint8_t>((k % 8 ? bits : 0) | (layers != 0) << (k % 8));
        }
    }
    std::memset(counters, 0, (size + 1) * stride);
#else
    const hn::CappedTag<std::uint8_t, 64> d;
    const auto zero = hn::Zero(d);
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t k = 0; k < stride; k += lanes) {
        auto layers = hn::Set(d, static_cast<std::uint8_t>(at_pole));
        std::uint8_t *from = counters + k, *to = blocked + k / 8;
        for (std::size_t r = 0; r < size; ++r, from += stride, to += size) {
            layers = hn::Add(layers, hn::Load(d, from));
            hn::Store(zero, d, from);
            hn::StoreMaskBits(d, hn::Ne(layers, zero), to);
        }
        hn::Store(zero, d, from);
    }
#endif
}

void count_open_bits(const std::uint8_t* blocked, std::size_t texels, std::uint8_t* open) {
    const hn::CappedTag<std::uint8_t, 64> d;
    for (std::size_t i = 0; i < texels; i += hn::Lanes(d))
        hn::StoreU(hn::Sub(hn::Set(d, samples_per_texel), hn::PopulationCount(hn::Load(d, blocked + i))), d,
                   open + i);
}

bool open_samples_by_contour(const Occluder& occluder, const ViewedOccluder& viewed, const Vec3f& view_point,
                             ContourScratch& scratch, int face_size, std::span<std::uint8_t> open) {
    const auto size = static_cast<std::size_t>(face_size), stride = samples_per_texel * size;
    if (face_size < 8 || occluder.one_sided_edges.edges.empty()) return false;
    counting_triangles(occluder, viewed, scratch.front);
    scratch.counters.reserve((size + 1) * stride);
    scratch.blocked.reserve(size * size);
    scratch.queue.reserve(2 * 4 * line_queue_length);
    scratch.lines.reserve(line_data_count * line_queue_length);

    int at_pole[3][2] = {{-2, -2}, {-2, -2}, {-2, -2}};
    for (int face = 0; face < cubemap_faces; ++face) {
        const FaceComponents& frame = all_face_components[face];
        int& layers = at_pole[frame.component[1]][frame.sign[1] > 0];
        if (layers == -2)
            layers =
                layers_along(occluder, viewed, view_point, scratch.front, frame.component[1], -frame.sign[1]);
        if (layers < 0) return false;
    }

    const std::size_t edges = contour_edges(occluder, viewed, scratch);
    bool sure = true;
    for (int face = 0; face < cubemap_faces; ++face) {
        const FaceComponents& frame = all_face_components[face];
        const int layers = at_pole[frame.component[1]][frame.sign[1] > 0];
        const unsigned outside = outside_left_or_right(face) | outside_below(face);
        scratch.entering.assign(stride + 1, 0);
        std::size_t queued = 0, drawn = 0;
        const auto draw_queue = [&] {
            sure &= set_up_lines(scratch.queue.data(), queued, face, face_size, scratch.lines.data());
            draw_lines(scratch.lines.data(), queued, face_size, scratch);
            drawn += queued;
            queued = 0;
        };
        for (const float *edge = scratch.edges.data(), *last = edge + 8 * edges; edge != last; edge += 8) {
            if (std::bit_cast<unsigned>(edge[3]) & std::bit_cast<unsigned>(edge[7]) & outside) continue;
            std::memcpy(scratch.queue.data() + 4 * queued, edge, 16);
            std::memcpy(scratch.queue.data() + 4 * (line_queue_length + queued), edge + 4, 16);
            if (++queued == line_queue_length) draw_queue();
        }
        if (queued != 0) draw_queue();
        std::uint8_t* texels = open.data() + std::size_t(face) * size * size;
        if (drawn == 0) {
            std::memset(texels, layers > 0 ? 0 : samples_per_texel, size * size);
            continue;
        }
        std::size_t most = std::size_t(layers), entering = std::size_t(layers);
        for (const std::int32_t change : scratch.entering)
            most = std::max(most, entering += std::size_t(change));
        sure &= most <= most_layers;
        sum_layers(face_size, layers, scratch);
        count_open_bits(scratch.blocked.data(), size * size, texels);
    }
    return sure;
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(open_samples_by_contour);

bool open_samples_by_contour(const Occluder& occluder, const ViewedOccluder& viewed, const Vec3f& view_point,
                             ContourScratch& scratch, int face_size, std::span<std::uint8_t> open) {
    return HWY_DYNAMIC_DISPATCH(open_samples_by_contour)(occluder, viewed, view_point, scratch, face_size,
                                                         open);
}

}  // namespace haarfield
#endif
