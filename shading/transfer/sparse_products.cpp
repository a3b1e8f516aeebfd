#include "shading/transfer/sparse_products.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/transfer/sparse_products.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef HAARFIELD_SPARSE_PRODUCTS_ONCE
#define HAARFIELD_SPARSE_PRODUCTS_ONCE

namespace haarfield {

/// Number of functions stored side by side, as one vector of floats per coefficient.
inline constexpr std::size_t columns = 8;

/// Three channels by column.
using ColumnSums = std::array<std::array<float, columns>, 3>;

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Eight lanes on all machines and no fused multiply-add: results are bit-identical everywhere.
using Floats = hn::CappedTag<float, columns>;
inline constexpr std::size_t parts = columns / hn::MaxLanes(Floats());

/// Converts half floats to floats.
void unpack_halves(const std::uint16_t* halves, std::size_t count, float* to) {
    const hn::ScalableTag<float> wide;
    const hn::Rebind<hwy::float16_t, decltype(wide)> narrow;
    const std::size_t lanes = hn::Lanes(wide);
    const auto* from = reinterpret_cast<const hwy::float16_t*>(halves);
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes)
        hn::StoreU(hn::PromoteTo(wide, hn::LoadU(narrow, from + i)), wide, to + i);
    if (i == count) return;
    // The remainder goes through a full vector.
    std::uint16_t last[HWY_MAX_BYTES / sizeof(float)] = {};
    float unpacked[HWY_MAX_BYTES / sizeof(float)];
    std::copy(halves + i, halves + count, last);
    hn::StoreU(hn::PromoteTo(wide, hn::LoadU(narrow, reinterpret_cast<const hwy::float16_t*>(last))), wide,
               unpacked);
    std::copy(unpacked, unpacked + (count - i), to + i);
}

/// Computes <vectors[row], c> for each of the functions c in `spread`.
void row_products(const SparseVectors& vectors, std::size_t row, std::size_t pages, const float* spread,
                  std::vector<float>& unpacked, ColumnSums& sums) {
    const std::size_t row_first = vectors.first[row * pages], row_end = vectors.first[(row + 1) * pages];
    unpacked.resize(std::max(unpacked.size(), 3 * (row_end - row_first)));
    unpack_halves(vectors.value.data() + 3 * row_first, 3 * (row_end - row_first), unpacked.data());
    hn::Vec<Floats> sum[3][parts];
    for (auto& channel : sum)
        for (auto& part : channel) part = hn::Zero(Floats());
    const float* value = unpacked.data();
    for (std::size_t page = 0; page < pages; ++page) {
        const float* const table = spread + (page << 16) * columns;
        const std::size_t end = vectors.first[row * pages + page + 1];
        for (std::size_t i = vectors.first[row * pages + page]; i < end; ++i, value += 3) {
            const float* const at = table + vectors.index[i] * columns;
            for (std::size_t part = 0; part < parts; ++part) {
                const auto coefficients = hn::LoadU(Floats(), at + part * hn::MaxLanes(Floats()));
                for (std::size_t c = 0; c < 3; ++c)
                    sum[c][part] = hn::Add(sum[c][part], hn::Mul(hn::Set(Floats(), value[c]), coefficients));
            }
        }
    }
    const auto scale = hn::Set(Floats(), vectors.scale[row]);
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t part = 0; part < parts; ++part)
            hn::StoreU(hn::Mul(sum[c][part], scale), Floats(),
                       sums[c].data() + part * hn::MaxLanes(Floats()));
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(unpack_halves);
HWY_EXPORT(row_products);

namespace {

/// Up to `columns` sparse functions, expanded side by side.
class SpreadFunctions {
public:
    explicit SpreadFunctions(const SparseVectorBlocks& functions, int face_size)
        : functions_(functions), values_(coefficient_count(face_size) * columns, 0.0f) {
        held_.fill(none);
    }

    /// Makes all samples of an interpolation present. Returns their columns, by sample.
    const std::array<std::size_t, columns>& hold(const Interpolation& at) {
        const auto count = static_cast<std::size_t>(at.count);
        if (count == count_ && std::equal(at.sample.begin(), at.sample.begin() + at.count, sample_.begin()))
            return column_;
        std::array<bool, columns> wanted{};
        std::array<bool, columns> found{};
        for (std::size_t k = 0; k < count; ++k) {
            const auto place = std::find(held_.begin(), held_.end(), at.sample[k]);
            if (place == held_.end()) continue;
            column_[k] = static_cast<std::size_t>(place - held_.begin());
            found[k] = wanted[column_[k]] = true;
        }
        for (std::size_t k = 0; k < count; ++k) {
            if (found[k]) continue;
            // Equal samples share the first one's column.
            const auto place = std::find(held_.begin(), held_.end(), at.sample[k]);
            if (place != held_.end()) {
                column_[k] = static_cast<std::size_t>(place - held_.begin());
                continue;
            }
            column_[k] =
                static_cast<std::size_t>(std::find(wanted.begin(), wanted.end(), false) - wanted.begin());
            wanted[column_[k]] = true;
            spread(at.sample[k], column_[k]);
        }
        sample_ = at.sample;
        count_ = count;
        return column_;
    }

    const float* values() const { return values_.data(); }

private:
    static constexpr std::uint32_t none = ~0u;

    void spread(std::uint32_t function, std::size_t column) {
        constexpr std::size_t in_block = SparseVectorBlocks::block_rows;
        if (held_[column] != none)
            functions_.block_of(held_[column])
                .for_each_index(held_[column] % in_block, [&](std::size_t, std::size_t index) {
                    values_[index * columns + column] = 0;
                });
        const SparseVectors& block = functions_.block_of(function);
        const std::size_t row = function % in_block, pages = block.pages();
        const std::size_t first = block.first[row * pages], count = block.first[(row + 1) * pages] - first;
        const float scale = block.scale[row];
        unpacked_.resize(std::max(unpacked_.size(), count));
        HWY_DYNAMIC_DISPATCH(unpack_halves)(block.value.data() + first, count, unpacked_.data());
        block.for_each_index(row, [&](std::size_t i, std::size_t index) {
            values_[index * columns + column] = unpacked_[i - first] * scale;
        });
        held_[column] = function;
    }

    const SparseVectorBlocks& functions_;
    std::vector<float> values_;                ///< By index and column.
    std::vector<float> unpacked_;              ///< Of the current function.
    std::array<std::uint32_t, columns> held_;  ///< Functions, by column.
    /// The previous interpolation.
    std::array<std::uint32_t, columns> sample_{};
    std::array<std::size_t, columns> column_{};
    std::size_t count_ = 0;
};

/// Returns the rows sorted by their first sample, which is below `samples`.
std::vector<const RowInterpolation*> rows_by_sample(const RowInterpolations& lists, std::size_t samples) {
    std::vector<std::size_t> start{0};  // Of each list.
    for (const auto& list : lists) start.push_back(start.back() + list.size());
    // In parallel, to overlap cache misses.
    std::vector<std::uint32_t> first_sample(start.back());
    tbb::parallel_for(std::size_t(0), lists.size(), [&](std::size_t l) {
        for (std::size_t i = 0; i < lists[l].size(); ++i)
            first_sample[start[l] + i] = lists[l][i].at.sample[0];
    });
    std::vector<std::uint32_t> end(samples + 1, 0);
    for (const std::uint32_t sample : first_sample) ++end[sample + 1];
    for (std::size_t s = 0; s < samples; ++s) end[s + 1] += end[s];
    std::vector<const RowInterpolation*> order(start.back());
    for (std::size_t l = 0; l < lists.size(); ++l)
        for (std::size_t i = 0; i < lists[l].size(); ++i)
            order[end[first_sample[start[l] + i]]++] = &lists[l][i];
    return order;
}

/// Prefetches the location of a row. Rows are scattered in memory.
void prefetch_place(const SparseVectors& block, std::size_t row, std::size_t pages) {
    hwy::Prefetch(&block.first[row * pages]);
    hwy::Prefetch(&block.scale[row]);
}
/// Prefetches the coefficients of a row.
void prefetch_coefficients(const SparseVectors& block, std::size_t row, std::size_t pages) {
    constexpr std::size_t line = 64 / sizeof(std::uint16_t);
    const std::size_t first = block.first[row * pages], end = block.first[(row + 1) * pages];
    for (std::size_t i = first; i < end; i += line) hwy::Prefetch(block.index.data() + i);
    for (std::size_t i = 3 * first; i < 3 * end; i += line) hwy::Prefetch(block.value.data() + i);
}

}  // namespace

Result<Done> add_interpolated_products(const SparseVectorBlocks& vectors, const SparseVectorBlocks& functions,
                                       const RowInterpolations& rows, std::span<Rgb> out,
                                       const std::stop_token& stop) {
    assert(out.size() == vectors.rows);
    if (stop.stop_requested()) return interruption();
    if (vectors.rows == 0 || functions.rows == 0) return Done{};
    const int face_size = vectors.blocks[0].face_size;
    const std::size_t pages = vectors.blocks[0].pages();
    const std::vector<const RowInterpolation*> order = rows_by_sample(rows, functions.rows);

    struct Worker {
        SpreadFunctions spread;
        std::vector<float> unpacked;
    };
    tbb::enumerable_thread_specific<Worker> workers([&] {
        return Worker{SpreadFunctions(functions, face_size), {}};
    });
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size(), 512), [&](const auto& range) {
        constexpr std::size_t soon = 2, later = 6;
        constexpr auto in_block = SparseVectorBlocks::block_rows;
        Worker& worker = workers.local();
        ColumnSums sums;
        for (std::size_t i = range.begin(); i != range.end() && !stop.stop_requested(); ++i) {
            if (i + later < range.end())
                prefetch_place(vectors.block_of(order[i + later]->row), order[i + later]->row % in_block,
                               pages);
            if (i + soon < range.end())
                prefetch_coefficients(vectors.block_of(order[i + soon]->row), order[i + soon]->row % in_block,
                                      pages);
            const auto& [row, at] = *order[i];
            const std::array<std::size_t, columns>& column = worker.spread.hold(at);
            HWY_DYNAMIC_DISPATCH(row_products)
            (vectors.block_of(row), row % in_block, pages, worker.spread.values(), worker.unpacked, sums);
            Rgb sum(0.0f);
            for (std::size_t k = 0; k < std::size_t(at.count); ++k) {
                const std::size_t from = column[k];
                sum += Rgb(sums[0][from], sums[1][from], sums[2][from]) * at.weight[k];
            }
            out[row] += sum;
        }
    });
    if (stop.stop_requested()) return interruption();
    return Done{};
}

}  // namespace haarfield
#endif
