#pragma once
/// Occlusion by the samples of a field as sparse vectors: the factors of the transfer vectors for a moving
/// instance.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/transfer/sparse_vectors.h"
#include "shading/walk/wide_visibility.h"

namespace haarfield {

/// Computes 1 - visibility at each sample of a field: planar, then spherical.
///
/// field, visibility  of one entity.
/// error              relative L2 error by dropping the smallest coefficients.
/// errors             interrupted.
/// cost               about 50 ns per wide node of these samples, in parallel on oneTBB.
Result<SparseVectorBlocks> occlusion_vectors(const VisibilityField& field, const WideVisibility& visibility,
                                             double error, const Progress& progress = {});

}  // namespace haarfield
