#pragma once
/// Inner products of many sparse vectors with functions that differ between vectors.

#include <tbb/parallel_for.h>

#include <algorithm>
#include <stop_token>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/samplers.h"
#include "shading/transfer/sparse_vectors.h"

namespace haarfield {

/// A row, and the interpolation that multiplies it; `open` of the interpolation is ignored.
struct RowInterpolation {
    std::uint32_t row;
    Interpolation at;
};

/// Rows in any order, each in at most one list.
using RowInterpolations = std::vector<std::vector<RowInterpolation>>;

/// Returns the results of find(i) for each i below `count`, except those without samples; computed in
/// parallel on oneTBB. Incomplete if stopped.
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

/// Computes out[row] += sum_k weight[k] <vectors[row], functions[sample[k]]> for the listed rows.
///
/// vectors    RGB.
/// functions  one channel, of the same face size.
/// errors     interrupted; some of `out` is then unchanged.
/// accuracy   float sums. Bit-identical on all processors, for any number of threads and order of rows.
/// cost       rows are processed in the order of their first sample. Up to eight functions are expanded at a
///            time and reused while subsequent rows need them. A row costs three multiplications and
///            additions of eight lanes per coefficient.
Result<Done> add_interpolated_products(const SparseVectorBlocks& vectors, const SparseVectorBlocks& functions,
                                       const RowInterpolations& rows, std::span<Rgb> out,
                                       const std::stop_token& stop = {});

}  // namespace haarfield
