#pragma once
/// Inner products of many sparse vectors with functions that differ from vector to vector.

#include <tbb/parallel_for.h>

#include <algorithm>
#include <stop_token>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/samplers.h"
#include "shading/transfer/sparse_vectors.h"

namespace haarfield {

/// A row, and what it is to be multiplied with; `open` of the interpolation is not used: it weighs no
/// function.
struct RowInterpolation {
    std::uint32_t row;
    Interpolation at;
};

/// Rows in any order, each in one list at most.
using RowInterpolations = std::vector<std::vector<RowInterpolation>>;

/// What find(i) finds for each i below `count`, as far as it has samples; by all of oneTBB's threads. Not
/// complete if it is stopped.
///
/// find  RowInterpolation find(std::size_t i)
template <class Find>
RowInterpolations found_interpolations(std::size_t count, const std::stop_token& stop, const Find& find) {
    constexpr std::size_t list_length = 1024;
    RowInterpolations lists((count + list_length - 1) / list_length);
    tbb::parallel_for(std::size_t(0), lists.size(), [&](std::size_t l) {
        if (stop.stop_requested()) return;
        const std::size_t first = l * list_length, end = std::min(count, first + list_length);
        for (std::size_t i = first; i < end; ++i)
            if (const RowInterpolation found = find(i); found.at.count > 0) lists[l].push_back(found);
    });
    return lists;
}

/// out[row] += sum_k weight[k] <vectors[row], functions[sample[k]]>, for the listed rows.
///
/// vectors    RGB.
/// functions  one channel, of the same face size.
/// errors     interrupted; then some of `out` is as it was.
/// accuracy   sums in float. The same bits on every processor, for any number of threads and order of rows.
/// cost       rows are taken in the order of their first sample; functions are spread out side by side, up to
///            eight at a time, and stay there as long as the next rows want them. Then a row costs three
///            multiplications and additions of eight lanes a coefficient.
Result<Done> add_interpolated_products(const SparseVectorBlocks& vectors, const SparseVectorBlocks& functions,
                                       const RowInterpolations& rows, std::span<Rgb> out,
                                       const std::stop_token& stop = {});

}  // namespace haarfield
