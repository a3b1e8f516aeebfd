#pragma once
/// What the samples of a field hide, as sparse vectors: what the vectors of a moving instance are multiplied
/// with.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/transfer/sparse_vectors.h"
#include "shading/walk/wide_visibility.h"

namespace haarfield {

/// 1 - visibility at each sample of a field: planar, then spherical.
///
/// field, visibility  of one entity.
/// error              of leaving out the smallest coefficients, in L2, relative.
/// errors             interrupted.
/// cost               some 50 ns a wide node of these samples, on all of oneTBB's threads.
Result<SparseVectorBlocks> occlusion_vectors(const VisibilityField& field, const WideVisibility& visibility,
                                             double error, const Progress& progress = {});

}  // namespace haarfield
