/// Vertices and planes of an occluder relative to a view point, in vectors.
/// Included once per instruction set, as Highway requires.

#include <cstring>

#include "fields/rasterizer/face_outcodes.h"
#include "fields/rasterizer/viewed_occluder.h"

#if defined(HAARFIELD_FIELDS_VIEWED_OCCLUDER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_FIELDS_VIEWED_OCCLUDER_INL_H
#undef HAARFIELD_FIELDS_VIEWED_OCCLUDER_INL_H
#else
#define HAARFIELD_FIELDS_VIEWED_OCCLUDER_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The cap keeps vectors within the padding of arrays; below it, the length is the machine's.
using Floats = hn::CappedTag<float, 16>;
using VF = hn::Vec<Floats>;
using Codes = hn::RebindToSigned<Floats>;
using VC = hn::Vec<Codes>;

struct ViewedVertices {
    VF x, y, z;  ///< Relative to the view point, in the cubemap's frame, never 0.
};

HWY_INLINE ViewedVertices viewed_vertices(VF x, VF y, VF z, const ViewedOccluder& viewed) {
    const Floats d;
    x = hn::Sub(x, hn::Set(d, viewed.view_point.x));
    y = hn::Sub(y, hn::Set(d, viewed.view_point.y));
    z = hn::Sub(z, hn::Set(d, viewed.view_point.z));
    const auto never_0 = [&](VF coordinate) {
        return hn::IfThenElse(hn::Eq(coordinate, hn::Zero(d)), hn::Set(d, almost_zero), coordinate);
    };
    if (!viewed.is_turned) return {never_0(x), never_0(y), never_0(z)};
    const auto along = [&](const Vec3f& axis) {
        return never_0(hn::Add(hn::Add(hn::Mul(hn::Set(d, axis.x), x), hn::Mul(hn::Set(d, axis.y), y)),
                               hn::Mul(hn::Set(d, axis.z), z)));
    };
    return {along(viewed.axes[0]), along(viewed.axes[1]), along(viewed.axes[2])};
}

/// Loads consecutive vertices in the layout of Occluder::padded_positions.
HWY_INLINE ViewedVertices load_viewed_vertices(const float* positions, const ViewedOccluder& viewed) {
    VF x, y, z, nothing;
    hn::LoadInterleaved4(Floats(), positions, x, y, z, nothing);
    return viewed_vertices(x, y, z, viewed);
}

#if HWY_TARGET != HWY_SCALAR
/// Loads x, y, z, 0 of every fourth vertex, starting at the first.
template <class D, class Vertex>
HWY_INLINE hn::Vec<D> every_fourth_vertex(D d, const Vertex& vertex, std::size_t first) {
    if constexpr (hn::MaxLanes(D()) == 4) {
        return hn::LoadU(d, vertex(first));
    } else {
        const hn::Half<D> half;
        return hn::Combine(d, every_fourth_vertex(half, vertex, first + hn::MaxLanes(half)),
                           every_fourth_vertex(half, vertex, first));
    }
}
#endif

/// Gathers one vertex per lane: vertex(lane) points to its x, y, z, 0. Copying them to a buffer first would
/// be slower: the vector load would wait for the stores.
template <class Vertex>
HWY_INLINE ViewedVertices gather_viewed_vertices(const Vertex& vertex, const ViewedOccluder& viewed) {
    const Floats d;
#if HWY_TARGET == HWY_SCALAR
    const float* from = vertex(0);
    return viewed_vertices(hn::LoadU(d, from), hn::LoadU(d, from + 1), hn::LoadU(d, from + 2), viewed);
#else
    const VF v0 = every_fourth_vertex(d, vertex, 0), v1 = every_fourth_vertex(d, vertex, 1),
             v2 = every_fourth_vertex(d, vertex, 2), v3 = every_fourth_vertex(d, vertex, 3);
    const hn::RepartitionToWide<Floats> wide;
    const auto pairs = [&](VF v) { return hn::BitCast(wide, v); };
    const auto xy01 = pairs(hn::InterleaveLower(d, v0, v1)), xy23 = pairs(hn::InterleaveLower(d, v2, v3)),
               z01 = pairs(hn::InterleaveUpper(d, v0, v1)), z23 = pairs(hn::InterleaveUpper(d, v2, v3));
    return viewed_vertices(hn::BitCast(d, hn::InterleaveLower(wide, xy01, xy23)),
                           hn::BitCast(d, hn::InterleaveUpper(wide, xy01, xy23)),
                           hn::BitCast(d, hn::InterleaveLower(wide, z01, z23)), viewed);
#endif
}

HWY_INLINE VF height_over_view_point(const ViewedVertices& v, const Vec3f& up) {
    const Floats d;
    return hn::Add(hn::Add(hn::Mul(hn::Set(d, up.x), v.x), hn::Mul(hn::Set(d, up.y), v.y)),
                   hn::Mul(hn::Set(d, up.z), v.z));
}

/// Returns the outcode bits (face_outcodes.h) that two vertices share, except the horizon's.
HWY_INLINE VC common_outcodes(const ViewedVertices& p, const ViewedVertices& q) {
    const Codes di;
    const auto bit_if = [&](auto mask, int bit) {
        return hn::IfThenElseZero(hn::RebindMask(di, mask), hn::Set(di, bit));
    };
    const auto pair = [&](VF p_a, VF p_b, VF q_a, VF q_b, int shift) {
        const VF p_minus = hn::Neg(p_b), q_minus = hn::Neg(q_b);
        return hn::Or(hn::Or(bit_if(hn::And(hn::Gt(p_a, p_b), hn::Gt(q_a, q_b)), 1 << shift),
                             bit_if(hn::And(hn::Lt(p_a, p_b), hn::Lt(q_a, q_b)), 2 << shift)),
                      hn::Or(bit_if(hn::And(hn::Gt(p_a, p_minus), hn::Gt(q_a, q_minus)), 4 << shift),
                             bit_if(hn::And(hn::Lt(p_a, p_minus), hn::Lt(q_a, q_minus)), 8 << shift)));
    };
    return hn::Or(hn::Or(pair(p.x, p.y, q.x, q.y, 0), pair(p.x, p.z, q.x, q.z, 4)),
                  pair(p.y, p.z, q.y, q.z, 8));
}

/// Returns the heights of the view point above planes of triangles (OccluderPlanes). The magnitude measures
/// the apparent thickness of a triangle, and the sign is that of its visible side. 0 if viewed exactly
/// edge-on, NaN for zero area.
template <class D>
HWY_INLINE hn::Vec<D> heights_over_planes(D d, const float* x, const float* y, const float* z,
                                          const float* offset, const Vec3f& from_centre) {
    return hn::Sub(hn::Add(hn::Add(hn::Mul(hn::LoadU(d, x), hn::Set(d, from_centre.x)),
                                   hn::Mul(hn::LoadU(d, y), hn::Set(d, from_centre.y))),
                           hn::Mul(hn::LoadU(d, z), hn::Set(d, from_centre.z))),
                   hn::LoadU(d, offset));
}

/// Returns a mask as an integer, one bit per lane.
template <class D>
HWY_INLINE std::uint64_t bits_of(D d, hn::Mask<D> mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    std::uint64_t bits = 0;
    std::memcpy(&bits, bytes, sizeof bits);
    return bits;
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
