#include "shading/sparse_products.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/sparse_products.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/four-inl.h"

#ifndef HAARFIELD_SPARSE_PRODUCTS_ONCE
#define HAARFIELD_SPARSE_PRODUCTS_ONCE

namespace haarfield {

/// Functions that lie side by side: one vector of so many floats a coefficient.
inline constexpr std::size_t columns = 8;

/// Three channels by column.
using ColumnSums = std::array<std::array<float, columns>, 3>;

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Half floats to floats.
void unpack_halves(const std::uint16_t* halves, std::size_t count, float* to) {
    const hn::ScalableTag<float> wide;
    const hn::Rebind<hwy::float16_t, decltype(wide)> narrow;
    const std::size_t lanes = hn::Lanes(wide);
    const auto* from = reinterpret_cast<const hwy::float16_t*>(halves);
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes)
        hn::StoreU(hn::PromoteTo(wide, hn::LoadU(narrow, from + i)), wide, to + i);
    if (i == count) return;
    // The rest by way of a full vector.
    std::uint16_t last[HWY_MAX_BYTES / sizeof(float)] = {};
    float unpacked[HWY_MAX_BYTES / sizeof(float)];
    std::copy(halves + i, halves + count, last);
    hn::StoreU(hn::PromoteTo(wide, hn::LoadU(narrow, reinterpret_cast<const hwy::float16_t*>(last))), wide,
               unpacked);
    std::copy(unpacked, unpacked + (count - i), to + i);
}

/// <vectors[row], c> for each of the functions c that lie side by side in `spread`.
void row_products(const SparseVectors& vectors, std::size_t row, const float* spread,
                  std::vector<float>& unpacked, ColumnSums& sums) {
    const std::size_t pages = vectors.pages();
    const std::size_t row_first = vectors.first[row * pages], row_end = vectors.first[(row + 1) * pages];
    unpacked.resize(std::max(unpacked.size(), 3 * (row_end - row_first)));
    unpack_halves(vectors.value.data() + 3 * row_first, 3 * (row_end - row_first), unpacked.data());
    Four red0 = all_four(0), red1 = red0, green0 = red0, green1 = red0, blue0 = red0, blue1 = red0;
    const float* value = unpacked.data();
    for (std::size_t page = 0; page < pages; ++page) {
        const float* const table = spread + (page << 16) * columns;
        const std::size_t end = vectors.first[row * pages + page + 1];
        for (std::size_t i = vectors.first[row * pages + page]; i < end; ++i, value += 3) {
            const float* const at = table + vectors.index[i] * columns;
            const Four low = load_four(at), high = load_four(at + 4);
            const Four red = all_four(value[0]), green = all_four(value[1]), blue = all_four(value[2]);
            red0 = red0 + red * low;
            red1 = red1 + red * high;
            green0 = green0 + green * low;
            green1 = green1 + green * high;
            blue0 = blue0 + blue * low;
            blue1 = blue1 + blue * high;
        }
    }
    const Four scale = all_four(vectors.scale[row]);
    store_four(red0 * scale, sums[0].data());
    store_four(red1 * scale, sums[0].data() + 4);
    store_four(green0 * scale, sums[1].data());
    store_four(green1 * scale, sums[1].data() + 4);
    store_four(blue0 * scale, sums[2].data());
    store_four(blue1 * scale, sums[2].data() + 4);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(row_products);

namespace {

/// Up to `columns` sparse functions, spread out side by side.
class SpreadFunctions {
public:
    explicit SpreadFunctions(const SparseVectorBlocks& functions, int face_size)
        : functions_(functions), values_(coefficient_count(face_size) * columns, 0.0f) {
        held_.fill(none);
    }

    /// Makes all samples of an interpolation present; column[k] says where sample k is.
    void hold(const Interpolation& at, std::array<std::size_t, columns>& column) {
        std::array<bool, columns> wanted{};
        std::array<bool, columns> found{};
        const auto count = static_cast<std::size_t>(at.count);
        for (std::size_t k = 0; k < count; ++k) {
            const auto place = std::find(held_.begin(), held_.end(), at.sample[k]);
            if (place == held_.end()) continue;
            column[k] = static_cast<std::size_t>(place - held_.begin());
            found[k] = wanted[column[k]] = true;
        }
        for (std::size_t k = 0; k < count; ++k) {
            if (found[k]) continue;
            // Of two equal samples the first one is spread.
            const auto place = std::find(held_.begin(), held_.end(), at.sample[k]);
            if (place != held_.end()) {
                column[k] = static_cast<std::size_t>(place - held_.begin());
                continue;
            }
            column[k] =
                static_cast<std::size_t>(std::find(wanted.begin(), wanted.end(), false) - wanted.begin());
            wanted[column[k]] = true;
            spread(at.sample[k], column[k]);
        }
    }

    const float* values() const { return values_.data(); }

private:
    static constexpr std::uint32_t none = ~0u;

    void spread(std::uint32_t function, std::size_t column) {
        if (held_[column] != none)
            for_each(held_[column],
                     [&](std::uint32_t index, float) { values_[index * columns + column] = 0; });
        for_each(function,
                 [&](std::uint32_t index, float value) { values_[index * columns + column] = value; });
        held_[column] = function;
    }

    template <class Use>
    void for_each(std::uint32_t function, const Use& use) const {
        functions_.block_of(function).for_each(function % SparseVectorBlocks::block_rows, use);
    }

    const SparseVectorBlocks& functions_;
    std::vector<float> values_;  ///< By index and column.
    std::array<std::uint32_t, columns> held_;
};

/// The rows that have anything to add up, by their first sample.
std::vector<std::uint32_t> rows_by_sample(const SparseVectorBlocks& vectors,
                                          std::span<const Interpolation> at, std::size_t samples) {
    const auto is_needed = [&](std::size_t row) { return at[row].count > 0 && !vectors.is_empty(row); };
    std::vector<std::uint32_t> end(samples + 1, 0);
    for (std::size_t row = 0; row < at.size(); ++row)
        if (is_needed(row)) ++end[at[row].sample[0] + 1];
    for (std::size_t s = 0; s < samples; ++s) end[s + 1] += end[s];
    std::vector<std::uint32_t> order(end.back());
    for (std::size_t row = 0; row < at.size(); ++row)
        if (is_needed(row)) order[end[at[row].sample[0]]++] = static_cast<std::uint32_t>(row);
    return order;
}

}  // namespace

Result<Done> interpolated_inner_products(const SparseVectorBlocks& vectors,
                                         const SparseVectorBlocks& functions,
                                         std::span<const Interpolation> at, std::span<Rgb> out,
                                         const std::stop_token& stop) {
    assert(at.size() == vectors.rows && out.size() == vectors.rows);
    std::fill(out.begin(), out.end(), Rgb(0.0f));
    if (vectors.rows == 0 || functions.rows == 0) return Done{};
    const int face_size = vectors.blocks[0].face_size;
    const std::vector<std::uint32_t> order = rows_by_sample(vectors, at, functions.rows);

    struct Worker {
        SpreadFunctions spread;
        std::vector<float> unpacked;
    };
    tbb::enumerable_thread_specific<Worker> workers([&] {
        return Worker{SpreadFunctions(functions, face_size), {}};
    });
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size(), 512), [&](const auto& range) {
        Worker& worker = workers.local();
        ColumnSums sums;
        std::array<std::size_t, columns> column{};
        for (std::size_t i = range.begin(); i != range.end() && !stop.stop_requested(); ++i) {
            const std::uint32_t row = order[i];
            worker.spread.hold(at[row], column);
            HWY_DYNAMIC_DISPATCH(row_products)
            (vectors.block_of(row), row % SparseVectorBlocks::block_rows, worker.spread.values(),
             worker.unpacked, sums);
            Rgb sum(0.0f);
            for (int k = 0; k < at[row].count; ++k) {
                const auto from = column[std::size_t(k)];
                sum += Rgb(sums[0][from], sums[1][from], sums[2][from]) * at[row].weight[std::size_t(k)];
            }
            out[row] = sum;
        }
    });
    if (stop.stop_requested()) return Error{"", interrupted};
    return Done{};
}

}  // namespace haarfield
#endif
