/// Edges as lines on a cubemap face, bit-identical for the span and the contour rasterizer.
/// Included once per instruction set, as Highway requires.

#include "fields/rasterizer/viewed_occluder-inl.h"

#if defined(HAARFIELD_FIELDS_EDGE_LINES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_FIELDS_EDGE_LINES_INL_H
#undef HAARFIELD_FIELDS_EDGE_LINES_INL_H
#else
#define HAARFIELD_FIELDS_EDGE_LINES_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

struct FaceVertices {
    VF u, v, w;
};

/// Loads consecutive vertices in the layout of SpanScratch::vertices.
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

/// Returns the number of sub-columns left of a vertex with w > 0: 0 to 8 face_size.
HWY_INLINE VF sub_columns_left_of(const FaceVertices& vertex, int face_size) {
    const Floats d;
    const VF per_unit = hn::Set(d, 4.0f * static_cast<float>(face_size)), one = hn::Set(d, 1.0f);
    const VF at = hn::Sub(hn::Mul(hn::Add(hn::Div(vertex.u, vertex.w), one), per_unit), hn::Set(d, 0.5f));
    return hn::Ceil(hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, 8.0f * static_cast<float>(face_size))));
}

/// The line of an edge: at texel column c, measured from the centre of the face, it is at texel row slope * c
/// + constant, measured from the top.
struct EdgeLine {
    VF slope, constant;
    VF turn;                   ///< w_p u_q - u_p w_q up to a positive factor: > 0 towards larger u.
    VF turn_terms;             ///< Sum of the absolute values of the terms of `turn`.
    hn::Mask<Floats> crosses;  ///< True if it crosses all columns, that is, is not parallel to them.
};

// The normal of the plane through the origin and an edge from p to q is computed as (p + q) x (q - p). Short
// edges lose no digits, and reversing the edge only changes the sign, bit for bit. So all triangles at an
// edge compute the same crossing with a sub-column.
//
// A line parallel to the sub-columns has no crossing. It is made to cross far above or far below, by the
// sign of its distance. A bias assigns a sub-column that coincides with the line to the triangles on both
// sides.
HWY_INLINE EdgeLine edge_line(const FaceVertices& p, const FaceVertices& q, int face_size) {
    const Floats d;
    const VF su = hn::Add(p.u, q.u), sv = hn::Add(p.v, q.v), sw = hn::Add(p.w, q.w);
    const VF du = hn::Sub(q.u, p.u), dv = hn::Sub(q.v, p.v), dw = hn::Sub(q.w, p.w);
    const VF nu = hn::Sub(hn::Mul(sv, dw), hn::Mul(sw, dv));
    const VF first = hn::Mul(sw, du), second = hn::Mul(su, dw), nv = hn::Sub(first, second);
    const VF nw = hn::Sub(hn::Mul(su, dv), hn::Mul(sv, du));
    const VF half = hn::Set(d, 0.5f * static_cast<float>(face_size));
    const VF largest = hn::Max(hn::Max(hn::Abs(nu), hn::Abs(nw)), hn::Set(d, 1e-20f));
    const auto crosses = hn::Gt(hn::Abs(nv), hn::Mul(largest, hn::Set(d, 0x1p-30f)));
    const VF scale = hn::Neg(hn::Div(hn::IfThenElse(crosses, hn::Set(d, 1.0f), hn::Set(d, 0x1p40f)),
                                     hn::IfThenElse(crosses, nv, largest)));
    return {hn::Mul(nu, scale),
            hn::Add(hn::Mul(half, hn::Mul(nw, scale)),
                    hn::IfThenElse(crosses, half, hn::Mul(half, hn::Set(d, -0x1p20f)))),
            nv, hn::Add(hn::Abs(first), hn::Abs(second)), crosses};
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
