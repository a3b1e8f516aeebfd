#pragma once
/// Phong lobes for many directions as sparse vectors: what the vectors of a moving eye are multiplied with.

#include <map>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/samplers.h"
#include "shading/transfer/sparse_vectors.h"

namespace haarfield {

/// The lobes  max(0, d.w)^exponent  of some exponents, for directions d on a grid over the cubemap: equal in
/// angle along each face's edges, borders included, so that interpolation is continuous over the sphere.
///
/// Only those for directions with  x >= y >= z >= 0  are kept: the others are their images under the cube's
/// 48 symmetries.
struct LobeShapes {
    using Coefficients = std::vector<std::pair<std::uint32_t, float>>;  ///< By index, sparse_vectors.h.

    int face_size = 64;
    int steps = 64;                   ///< Grid cells along a face's edge.
    std::vector<float> exponents;     ///< Ascending.
    std::vector<Coefficients> lobes;  ///< By exponent, and the direction's number.
    CoefficientSpectrum spectrum{};   ///< Over all that are kept.
};

/// exponents   each in [1, 1000].
/// error       of truncation, in L2, relative, on each face.
/// cost        561 transforms an exponent.
/// errors      interrupted.
Result<LobeShapes> lobe_shapes(std::span<const float> exponents, int face_size, float error,
                               const Progress& progress = {});

/// The lobes for all directions of the grid, as sparse vectors.
struct LobeVectors {
    int steps = 64;                        ///< As in LobeShapes.
    std::map<float, std::uint32_t> first;  ///< Row of an exponent's first lobe.
    SparseVectorBlocks lobes;              ///< By first + (face * (steps+1) + row) * (steps+1) + column.
};

/// factor      spectrum of what the lobes will be multiplied with.
/// error       by how much leaving out coefficients may change the products: relative, root mean square.
/// accuracy    interpolation errs by 0.5 % of the peak at exponent 60; by up to 6 % at 1000, energy kept.
/// errors      interrupted.
Result<LobeVectors> lobe_vectors(const LobeShapes& shapes, const CoefficientSpectrum& factor, float error,
                                 const Progress& progress = {});

/// The four lobes round a unit direction, as rows of `lobes`. The exponent is one of `first` (asserted).
Interpolation lobe_interpolation(const LobeVectors& vectors, float exponent, const Vec3f& direction);

}  // namespace haarfield
