#pragma once
/// Light that is concentrated in cells over which radiance transfer vectors hold the cosine constant.
///
/// Over a cell c of 1/16 of a face's edge, a vertex with the normal N that sees the share V of it receives
///     int_c L V (N.w) dw  =  V [ mean(L) int_c N.w  +  N.D ],     D = int_c (L - mean(L)) (w - mean(w)) dw.
/// The vectors have the first term. A sun that stands beside the middle of its cell lights all vertices that
/// face one way too much or too little: that is the second term, which this adds up, as V is known from the
/// vectors: they have V (N.mean(w)).

#include "shading/transfer/grouped_columns.h"

namespace haarfield {

/// One concentrated source: a cell, or some that lie side by side.
struct ConcentratedLight {
    Vec3f direction;  ///< Unit length; of the cells' middles.
    Rgb colour;       ///< Of D: its channels are as the colour's are.
    /// The inner products with a vector, as x, y and z, are the sum over the cells of D times the vector's
    /// mean. [1/colour]
    FewCoefficients moments;
};

/// The directions of the texels' middles as coefficients: x, y, z as red, green, blue.
DenseCoefficients direction_coefficients(int face_size);

/// What matters of a light, the largest first; two sources at most.
///
/// light       lighting.h.
/// directions  direction_coefficients of the light's face size.
/// error       what is left out is about this fraction of a vertex's irradiance, unless there are more
///             sources.
/// cost        O(coefficients).
std::vector<ConcentratedLight> concentrated_light(const DenseCoefficients& light,
                                                  const DenseCoefficients& directions, float error);

}  // namespace haarfield
