#pragma once
/// Phong lobes for many directions as sparse vectors: the factors of the transfer vectors for a moving eye.

#include <map>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/samplers.h"
#include "shading/transfer/sparse_vectors.h"

namespace haarfield {

/// The lobes  max(0, d.w)^exponent  for several exponents and for directions d on a grid over the cubemap.
/// The grid is equiangular along each face's edges and includes the borders, so that interpolation is
/// continuous over the sphere.
///
/// Only lobes with  x >= y >= z >= 0  are stored: the others are their images under the 48 symmetries of the
/// cube.
struct LobeShapes {
    using Coefficients = std::vector<std::pair<std::uint32_t, float>>;  ///< By index (sparse_vectors.h).

    int face_size = 64;
    int steps = 64;                   ///< Grid cells along a face's edge.
    std::vector<float> exponents;     ///< Ascending.
    std::vector<Coefficients> lobes;  ///< By exponent and index of the direction.
    CoefficientSpectrum spectrum{};   ///< Over all stored lobes.
};

/// Computes the lobes.
///
/// exponents   each in [1, 1000].
/// error       relative L2 error of truncation, by face.
/// cost        561 transforms per exponent.
/// errors      interrupted.
Result<LobeShapes> lobe_shapes(std::span<const float> exponents, int face_size, float error,
                               const Progress& progress = {});

/// The lobes for all directions of the grid, as sparse vectors.
struct LobeVectors {
    int steps = 64;                        ///< As in LobeShapes.
    std::map<float, std::uint32_t> first;  ///< Row of the first lobe of an exponent.
    SparseVectorBlocks lobes;              ///< By first + (face * (steps+1) + row) * (steps+1) + column.
};

/// Computes the vectors.
///
/// factor      spectrum of the functions that the lobes will multiply.
/// error       relative change of the products by dropped coefficients, root mean square.
/// accuracy    interpolation errs by 0.5 % of the peak at exponent 60, and by up to 6 % at 1000; energy is
///             preserved.
/// errors      interrupted.
Result<LobeVectors> lobe_vectors(const LobeShapes& shapes, const CoefficientSpectrum& factor, float error,
                                 const Progress& progress = {});

/// Returns the four lobes around a unit direction, as rows of `lobes`. The exponent is one of `first`
/// (asserted).
Interpolation lobe_interpolation(const LobeVectors& vectors, float exponent, const Vec3f& direction);

}  // namespace haarfield
