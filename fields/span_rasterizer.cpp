#include "fields/span_rasterizer.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>

#include "fields/view_frame.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/span_rasterizer.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef HAARFIELD_SPAN_RASTERIZER_ONCE
#define HAARFIELD_SPAN_RASTERIZER_ONCE

namespace haarfield {

/// By the bits that all vertices have in common: the faces that the triangle may touch.
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

/// Triangles wait in a queue per face until there are enough for full vectors.
inline constexpr std::size_t queue_length = 64;
inline constexpr std::size_t queue_floats = queue_length * 4;  ///< Of one of the three vertices.

/// What drawing needs of each triangle in the queue: SoA, queue_length floats each.
enum EdgeData : std::size_t {
    edge_slope,      ///< Three of them: the side is at row  slope * c + constant,  c the column.
    edge_lower = 3,  ///< Three constants of sides that the rows lie under (at larger v), or -huge.
    edge_upper = 6,  ///< Three constants of sides that the rows lie over, or +huge.
    edge_first = 9,  ///< The first and
    edge_last = 10,  ///< the last sub-column.
    edge_data_count = 11
};

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A cap, so that vectors never exceed the padding; below it the length is the machine's.
using Floats = hn::CappedTag<float, 16>;
using VF = hn::Vec<Floats>;
using Words = hn::CappedTag<std::uint64_t, 8>;

/// Vertices from the view point, with their outcodes.
void relative_vertices(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon, float* out) {
    const Floats d;
    const hn::RebindToSigned<Floats> di;
    const std::size_t lanes = hn::Lanes(d), count = occluder.positions.size();
    const VF ox = hn::Set(d, view_point.x), oy = hn::Set(d, view_point.y), oz = hn::Set(d, view_point.z);
    const Vec3f normal = horizon ? *horizon : Vec3f(0.0f);
    const VF nx = hn::Set(d, normal.x), ny = hn::Set(d, normal.y), nz = hn::Set(d, normal.z);
    const VF low = hn::Set(d, horizon ? 1e-5f * occluder.bounds.radius() : -1.0f);
    const SoaPoints& points = occluder.soa_positions;
    const auto bit_if = [&](auto mask, int bit) {
        return hn::IfThenElseZero(hn::RebindMask(di, mask), hn::Set(di, bit));
    };
    const auto pair = [&](VF a, VF b, int shift) {
        const VF minus = hn::Neg(b);
        return hn::Or(hn::Or(bit_if(hn::Gt(a, b), 1 << shift), bit_if(hn::Lt(a, b), 2 << shift)),
                      hn::Or(bit_if(hn::Gt(a, minus), 4 << shift), bit_if(hn::Lt(a, minus), 8 << shift)));
    };
    for (std::size_t v = 0; v < count; v += lanes) {
        const VF x = hn::Sub(hn::LoadU(d, points.x.data() + v), ox),
                 y = hn::Sub(hn::LoadU(d, points.y.data() + v), oy),
                 z = hn::Sub(hn::LoadU(d, points.z.data() + v), oz);
        auto code = hn::Or(hn::Or(pair(x, y, 0), pair(x, z, 4)), pair(y, z, 8));
        const VF height = hn::Add(hn::Add(hn::Mul(nx, x), hn::Mul(ny, y)), hn::Mul(nz, z));
        code = hn::Or(code, bit_if(hn::Le(height, low), below_horizon));
        hn::StoreInterleaved4(x, y, z, hn::BitCast(d, code), d, out + 4 * v);
    }
}

/// Two words per 64 triangles: those that the view point is in front of, and those that it is behind.
void facing_bits(const Occluder& occluder, const Vec3f& view_point, std::uint64_t* bits) {
    const Floats d;
    const std::size_t lanes = hn::Lanes(d);
    const Vec3f from_centre(Vec3d(view_point) - occluder.planes_centre);
    const VF px = hn::Set(d, from_centre.x), py = hn::Set(d, from_centre.y), pz = hn::Set(d, from_centre.z);
    const SoaPlanes& planes = occluder.planes;
    const auto word_part = [&](auto mask) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, mask, bytes);
        std::uint64_t part;
        std::memcpy(&part, bytes, sizeof part);
        return part;
    };
    for (std::size_t first = 0; first < occluder.triangles.size(); first += 64, bits += 2) {
        bits[0] = bits[1] = 0;
        for (std::size_t i = 0; i < 64; i += lanes) {
            const std::size_t t = first + i;
            const VF height = hn::Add(hn::Add(hn::Mul(hn::LoadU(d, planes.x.data() + t), px),
                                              hn::Mul(hn::LoadU(d, planes.y.data() + t), py)),
                                      hn::Mul(hn::LoadU(d, planes.z.data() + t), pz));
            const VF offset = hn::LoadU(d, planes.offset.data() + t);
            bits[0] |= word_part(hn::Gt(height, offset)) << i;
            bits[1] |= word_part(hn::Lt(height, offset)) << i;
        }
    }
}

struct FaceVertices {
    VF u, v, w;
};

HWY_INLINE FaceVertices load_vertices(const float* from, const FaceComponents& frame) {
    const Floats d;
    VF x, y, z, code;
    hn::LoadInterleaved4(d, from, x, y, z, code);
    const auto component = [&](int i) {
        const VF chosen = frame.component[i] == 0 ? x : frame.component[i] == 1 ? y : z;
        return hn::Mul(chosen, hn::Set(d, frame.sign[i]));
    };
    return {component(0), component(1), component(2)};
}

// A direction d lies in the cone of the triangle (a, b, c), seen from the origin, iff d = αa + βb + γc with
// α, β, γ >= 0: three half-spaces through the origin, whose normals are cross products of two vertices. No
// clipping is needed, wherever the vertices are. The normal of the side from p to q is taken as
// (p + q) x (q - p): short edges lose no digits, and for the neighbour, which has it from q to p, it is the
// same but for its sign, to the last bit. So both compute the same crossing with a sub-column, and every
// sample is on one side or on both.
//
// A side that runs along the sub-columns has no crossing. It is made to cross far above or far below, by the
// sign of its distance, with a bias that lets both neighbours have a sub-column that it meets exactly.
HWY_INLINE void set_up_side(const FaceVertices& p, const FaceVertices& q, float half_size, float* edges,
                            std::size_t k) {
    const Floats d;
    const VF su = hn::Add(p.u, q.u), sv = hn::Add(p.v, q.v), sw = hn::Add(p.w, q.w);
    const VF du = hn::Sub(q.u, p.u), dv = hn::Sub(q.v, p.v), dw = hn::Sub(q.w, p.w);
    const VF nu = hn::Sub(hn::Mul(sv, dw), hn::Mul(sw, dv));
    const VF nv = hn::Sub(hn::Mul(sw, du), hn::Mul(su, dw));
    const VF nw = hn::Sub(hn::Mul(su, dv), hn::Mul(sv, du));
    const VF half = hn::Set(d, half_size), zero = hn::Zero(d);
    const VF largest = hn::Max(hn::Max(hn::Abs(nu), hn::Abs(nw)), hn::Set(d, 1e-20f));
    const auto crosses = hn::Gt(hn::Abs(nv), hn::Mul(largest, hn::Set(d, 0x1p-30f)));
    const VF scale = hn::Neg(hn::Div(hn::IfThenElse(crosses, hn::Set(d, 1.0f), hn::Set(d, 0x1p40f)),
                                     hn::IfThenElse(crosses, nv, largest)));
    const VF slope = hn::Mul(nu, scale);
    const VF constant = hn::Add(hn::Mul(half, hn::Mul(nw, scale)),
                                hn::IfThenElse(crosses, half, hn::Mul(half, hn::Set(d, -0x1p20f))));
    const auto is_upper = hn::And(crosses, hn::Lt(nv, zero));
    hn::StoreU(slope, d, edges + (edge_slope + k) * queue_length);
    hn::StoreU(hn::IfThenElse(is_upper, hn::Set(d, -1e30f), constant), d,
               edges + (edge_lower + k) * queue_length);
    hn::StoreU(hn::IfThenElse(is_upper, constant, hn::Set(d, 1e30f)), d,
               edges + (edge_upper + k) * queue_length);
}

void set_up(const float* queue, std::size_t count, int face, int face_size, float* edges) {
    const Floats d;
    const FaceComponents frame = all_face_components[face];
    const float half_size = 0.5f * static_cast<float>(face_size);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const FaceVertices a = load_vertices(queue + 4 * i, frame),
                           b = load_vertices(queue + queue_floats + 4 * i, frame),
                           c = load_vertices(queue + 2 * queue_floats + 4 * i, frame);
        // Seen from the front a triangle turns counter-clockwise, so that normals of (b, a) and so on point
        // in.
        set_up_side(b, a, half_size, edges + i, 0);
        set_up_side(c, b, half_size, edges + i, 1);
        set_up_side(a, c, half_size, edges + i, 2);

        const VF pa = hn::Div(a.u, a.w), pb = hn::Div(b.u, b.w), pc = hn::Div(c.u, c.w);
        const VF one = hn::Set(d, 1.0f), minus_one = hn::Set(d, -1.0f);
        // Around the view point the projection is not bounded by the vertices.
        const auto bounded = hn::Gt(hn::Min(a.w, hn::Min(b.w, c.w)), hn::Zero(d));
        const VF lowest = hn::IfThenElse(bounded, hn::Min(pa, hn::Min(pb, pc)), minus_one),
                 highest = hn::IfThenElse(bounded, hn::Max(pa, hn::Max(pb, pc)), one);
        // Sub-column k is at u = (k + 1/2) / (4 face_size) - 1; a margin for rounding.
        const VF per_unit = hn::Set(d, 8 * half_size);
        const VF margin = hn::Set(d, 0.01f), middle = hn::Set(d, 0.5f);
        const VF first =
            hn::Sub(hn::Mul(hn::Add(hn::Max(lowest, minus_one), one), per_unit), hn::Add(middle, margin));
        const VF last =
            hn::Sub(hn::Mul(hn::Add(hn::Min(highest, one), one), per_unit), hn::Sub(middle, margin));
        hn::StoreU(hn::Max(hn::Ceil(first), hn::Zero(d)), d, edges + edge_first * queue_length + i);
        hn::StoreU(hn::Min(hn::Floor(last), hn::Sub(hn::Mul(per_unit, hn::Set(d, 2.0f)), one)), d,
                   edges + edge_last * queue_length + i);
    }
}

/// All bits from bit n on, 0 <= n <= 64.
template <class DU>
HWY_INLINE hn::Vec<DU> bits_from(DU d, hn::Vec<DU> n) {
    const auto ones = hn::Set(d, ~std::uint64_t(0));
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2
    return hn::Shl(ones, n);  // here a shift by 64 gives 0
#else
    const auto rest = hn::And(n, hn::Set(d, 63));
    return hn::IfThenElseZero(hn::Eq(rest, n), hn::Shl(ones, rest));
#endif
}

/// Blocks the rows from begin up to, but not at, end in as many sub-columns as the vectors have lanes.
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
    const VF steps = hn::Mul(hn::Iota(d, 0), hn::Set(d, 1.0f / samples_per_texel));
    for (std::size_t i = 0; i < count; ++i) {
        const auto data = [&](std::size_t k) { return edges[k * queue_length + i]; };
        const auto first = static_cast<int>(data(edge_first)), last = static_cast<int>(data(edge_last));
        if (first > last) continue;
        const VF slope0 = hn::Set(d, data(0)), slope1 = hn::Set(d, data(1)), slope2 = hn::Set(d, data(2));
        const VF lower0 = hn::Set(d, data(3)), lower1 = hn::Set(d, data(4)), lower2 = hn::Set(d, data(5));
        const VF upper0 = hn::Set(d, data(6)), upper1 = hn::Set(d, data(7)), upper2 = hn::Set(d, data(8));
        for (std::size_t k = std::size_t(first) & ~(lanes - 1); k <= std::size_t(last); k += lanes) {
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
            const auto begin =
                hn::BitCast(du, hn::ConvertTo(di, hn::Ceil(hn::Min(hn::Max(from, zero), rows))));
            const auto end = hn::BitCast(
                du, hn::Add(hn::ConvertTo(di, hn::Floor(hn::Min(hn::Max(to, minus_one), last_row))),
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
    blocked.touched |= 1u << face;
}

void look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon,
             ViewedOccluder& viewed) {
    viewed.vertices.reserve(4 * (occluder.positions.size() + 16));
    viewed.facing.reserve(2 * (occluder.triangles.size() / 64 + 1));
    viewed.horizon = horizon != nullptr;
    relative_vertices(occluder, view_point, horizon, viewed.vertices.data());
    facing_bits(occluder, view_point, viewed.facing.data());
}

void block_spans(const Occluder& occluder, std::uint32_t first, std::uint32_t last,
                 const ViewedOccluder& viewed, SpanScratch& scratch, BlockedSamples& blocked) {
    scratch.queue.reserve(cubemap_faces * 3 * queue_floats);
    scratch.edges.reserve(edge_data_count * queue_length);
    const float* vertices = viewed.vertices.data();
    std::size_t queued[cubemap_faces] = {};
    const auto block = [&](std::uint32_t t, bool front) {
        const auto& [i, j, k] = occluder.triangles[t];
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
    for (std::uint32_t start = first & ~63u; start < last; start += 64) {
        const std::uint64_t front = viewed.facing.data()[start / 32],
                            back = viewed.facing.data()[start / 32 + 1];
        // A triangle seen edge-on is neither.
        const std::uint64_t two_sided = ~bits_below(occluder.one_sided, start);
        std::uint64_t drawn =
            (front | (back & two_sided)) & bits_below(last, start) & ~bits_below(first, start);
        for (; drawn != 0; drawn &= drawn - 1) {
            const int i = std::countr_zero(drawn);
            block(start + static_cast<std::uint32_t>(i), front >> i & 1);
        }
    }
    for (int face = 0; face < cubemap_faces; ++face)
        if (queued[face] != 0) block_queue(scratch, queued[face], face, blocked);
}

/// The transpose of 8 x 8 bytes, one block a lane: byte r of row c becomes byte c of row r.
template <class DU, class V>
HWY_INLINE void transpose_bytes(DU d, V (&rows)[8]) {
    const auto exchange = [&](V& a, V& b, auto shift, std::uint64_t low) {
        const V mask = hn::Set(d, low);
        const V t = hn::And(hn::Xor(hn::ShiftRight<shift()>(a), b), mask);
        b = hn::Xor(b, t);
        a = hn::Xor(a, hn::ShiftLeft<shift()>(t));
    };
    for (int i = 0; i < 4; ++i)
        exchange(rows[i], rows[i + 4], std::integral_constant<int, 32>(), 0x00000000ffffffff);
    for (const int i : {0, 1, 4, 5})
        exchange(rows[i], rows[i + 2], std::integral_constant<int, 16>(), 0x0000ffff0000ffff);
    for (const int i : {0, 2, 4, 6})
        exchange(rows[i], rows[i + 1], std::integral_constant<int, 8>(), 0x00ff00ff00ff00ff);
}

/// Open samples of a texel column, of up to 64 rows; from the masks of its eight sub-columns.
HWY_INLINE void count_column(const std::uint64_t* sub_columns, std::uint8_t* open) {
#if HWY_TARGET == HWY_SCALAR
    for (int r = 0; r < 64; ++r) {
        open[r] = samples_per_texel;
        for (int j = 0; j < samples_per_texel; ++j)
            open[r] = static_cast<std::uint8_t>(open[r] - (sub_columns[j] >> r & 1));
    }
#else
    const hn::CappedTag<std::uint8_t, 64> d;
    const auto* mask = reinterpret_cast<const std::uint8_t*>(sub_columns);
    for (std::size_t r = 0; r < 64; r += hn::Lanes(d)) {
        auto count = hn::Set(d, samples_per_texel);
        for (std::size_t j = 0; j < samples_per_texel; ++j)  // a mask is -1 where it is set
            count = hn::Add(count, hn::VecFromMask(d, hn::LoadMaskBits(d, mask + 8 * j + r / 8)));
        hn::Store(count, d, open + r);
    }
#endif
}

/// Eight texel columns of a strip, from texel column c on; row after row is size texels apart.
void count_columns(const std::uint64_t* words, std::size_t column_count, std::size_t rows, std::size_t size,
                   std::uint8_t* open) {
    const Words d;
    std::uint64_t any = 0;
    for (std::size_t k = 0; k < samples_per_texel * column_count; ++k) any |= words[k];
    if (any == 0) {
        for (std::size_t r = 0; r < rows; ++r) std::memset(open + r * size, samples_per_texel, column_count);
        return;
    }
    alignas(64) std::uint64_t columns[8][8], turned[8][8];  // 64 bytes each, one a row
    for (std::size_t k = 0; k < column_count; ++k)
        count_column(words + samples_per_texel * k, reinterpret_cast<std::uint8_t*>(columns[k]));
    for (std::size_t k = column_count; k < 8; ++k) std::memset(columns[k], 0, 64);
    for (std::size_t b = 0; b < 8; b += hn::Lanes(d)) {
        hn::Vec<Words> block[8];
        for (std::size_t k = 0; k < 8; ++k) block[k] = hn::Load(d, columns[k] + b);
        transpose_bytes(d, block);
        for (std::size_t k = 0; k < 8; ++k) hn::Store(block[k], d, turned[k] + b);
    }
    for (std::size_t r = 0; r < rows; ++r) std::memcpy(open + r * size, &turned[r % 8][r / 8], column_count);
}

void count_open(BlockedSamples& blocked, std::uint8_t* open) {
    const auto size = static_cast<std::size_t>(blocked.face_size);
    const std::size_t face_texels = size * size;
    for (int face = 0; face < cubemap_faces; ++face, open += face_texels) {
        if (!(blocked.touched >> face & 1)) {
            std::memset(open, samples_per_texel, face_texels);
            continue;
        }
        for (std::size_t s = 0; s < blocked.strips; ++s) {
            std::uint64_t* words = blocked.strip(face, int(s));
            for (std::size_t c = 0; c < size; c += 8)
                count_columns(words + samples_per_texel * c, std::min<std::size_t>(8, size - c),
                              std::min<std::size_t>(64, size - 64 * s), size, open + 64 * s * size + c);
            std::memset(words, 0, blocked.stride * sizeof(std::uint64_t));
        }
    }
    blocked.touched = 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(look_at);
HWY_EXPORT(block_spans);
HWY_EXPORT(count_open);

BlockedSamples::BlockedSamples(int size)
    : face_size(size),
      strips((std::size_t(size) + 63) / 64),
      stride(std::max<std::size_t>(samples_per_texel * std::size_t(size), 64)) {
    bits.reserve(cubemap_faces * strips * stride);
    std::memset(bits.data(), 0, cubemap_faces * strips * stride * sizeof(std::uint64_t));
}

void look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon,
             ViewedOccluder& viewed) {
    HWY_DYNAMIC_DISPATCH(look_at)(occluder, view_point, horizon, viewed);
}

void block_spans(const Occluder& occluder, std::uint32_t first, std::uint32_t last,
                 const ViewedOccluder& viewed, SpanScratch& scratch, BlockedSamples& blocked) {
    HWY_DYNAMIC_DISPATCH(block_spans)(occluder, first, last, viewed, scratch, blocked);
}

void count_open_samples(BlockedSamples& blocked, std::uint8_t* open) {
    HWY_DYNAMIC_DISPATCH(count_open)(blocked, open);
}

}  // namespace haarfield
#endif
