#pragma once
/// Inner products of many sparse vectors with functions that differ from vector to vector.

#include <stop_token>

#include "fields/progress.h"
#include "fields/result.h"
#include "fields/samplers.h"
#include "shading/sparse_vectors.h"

namespace haarfield {

/// out[row] = sum_k at[row].weight[k] <vectors[row], functions[at[row].sample[k]]>, for all rows.
///
/// vectors    RGB.
/// functions  one channel, of the same face size.
/// at         one a row; `open` is not used: it weighs no function.
/// errors     interrupted.
/// accuracy   sums in float. The same bits on every processor and for any number of threads.
/// cost       rows are taken in the order of their first sample; functions are spread out side by side, up to
///            eight at a time, and stay there as long as the next rows want them. Then a row costs three
///            multiplications and additions of eight lanes a coefficient.
Result<Done> interpolated_inner_products(const SparseVectorBlocks& vectors,
                                         const SparseVectorBlocks& functions,
                                         std::span<const Interpolation> at, std::span<Rgb> out,
                                         const std::stop_token& stop = {});

}  // namespace haarfield
