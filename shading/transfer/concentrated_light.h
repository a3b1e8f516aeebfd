#pragma once
/// Corrects radiance transfer for light concentrated in cells over which the vectors keep the cosine
/// constant.
///
/// For a cell c of 1/16 of a face's edge, a vertex with normal N and visibility V of the cell receives
///
///     int_c L V (N.w) dw  =  V [ mean(L) int_c N.w  +  N.D ],     D = int_c (L - mean(L)) (w - mean(w)) dw.
///
/// The vectors contain the first term only. With this term alone, a sun away from the centre of its cell
/// lights all vertices of one orientation too much or too little. The second term corrects this. V is
/// computed from the vectors, which contain V (N.mean(w)).

#include "shading/transfer/grouped_columns.h"

namespace haarfield {

/// A concentrated source: one cell, or several adjacent cells.
struct ConcentratedLight {
    Vec3f direction;  ///< Mean direction of the cells' centres; unit length.
    Rgb colour;       ///< Colour of D: the proportions of its channels.
    /// Coefficients whose inner products with a vector, as x, y and z, are the sum over the cells of D times
    /// the vector's mean. [1/colour]
    SelectedCoefficients moments;
};

/// Returns the directions of the texel centres as coefficients: x, y, z as red, green, blue.
DenseCoefficients direction_coefficients(int face_size);

/// Finds the most important concentrated sources of a light, the largest first; at most two.
///
/// light       lighting.h.
/// directions  direction_coefficients of the light's face size.
/// error       the omitted sources change a vertex's irradiance by about this fraction, unless there are more
///             than two.
/// cost        O(coefficients).
std::vector<ConcentratedLight> concentrated_light(const DenseCoefficients& light,
                                                  const DenseCoefficients& directions, float error);

}  // namespace haarfield
