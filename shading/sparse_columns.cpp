#include "shading/sparse_columns.h"

#include <algorithm>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/sparse_columns.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/four-inl.h"

#ifndef HAARFIELD_SPARSE_COLUMNS_ONCE
#define HAARFIELD_SPARSE_COLUMNS_ONCE

namespace haarfield {

/// Values that are converted at a time, and zeros at the end so that this may be done anywhere.
inline constexpr std::size_t converted_at_a_time = 16;

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Sixteen half floats to floats.
HWY_INLINE void convert_halves(const std::uint16_t* halves, float* to) {
    const hn::CappedTag<float, converted_at_a_time> wide;
    const hn::Rebind<hwy::float16_t, decltype(wide)> narrow;
    const auto* from = reinterpret_cast<const hwy::float16_t*>(halves);
    for (std::size_t i = 0; i < converted_at_a_time; i += hn::Lanes(wide))
        hn::Store(hn::PromoteTo(wide, hn::LoadU(narrow, from + i)), wide, to + i);
}

void add_columns(const SparseColumns& vectors, const FewCoefficients& f, std::array<float, 4>* sums) {
    alignas(64) float values[converted_at_a_time];
    for (std::size_t k = 0; k < f.index.size(); ++k) {
        const Four factor = load_four(f.value[k].data());
        std::size_t i = vectors.first[f.index[k]];
        const std::size_t end = vectors.first[f.index[k] + 1];
        while (i < end) {
            convert_halves(vectors.value.data() + i, values);
            const std::uint16_t* row = vectors.row.data() + i;
            const std::size_t count = std::min(converted_at_a_time, end - i);
            for (std::size_t j = 0; j < count; ++j) {
                float* sum = sums[row[j]].data();
                store_four(load_four(sum) + all_four(values[j]) * factor, sum);
            }
            i += count;
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(add_columns);

SparseColumns::SparseColumns(const SparseVectors& vectors) : scale(vectors.scale) {
    assert(vectors.channels == 1 && vectors.rows() <= 0x10000);
    const std::size_t pages = vectors.pages(), count = vectors.index.size();
    first.assign(coefficient_count(vectors.face_size) + 1, 0);
    const auto for_each = [&](const auto& use) {
        for (std::size_t r = 0; r < vectors.rows(); ++r)
            for (std::size_t page = 0; page < pages; ++page)
                for (std::size_t i = vectors.first[r * pages + page]; i < vectors.first[r * pages + page + 1];
                     ++i)
                    use(page << 16 | vectors.index[i], r, i);
    };
    // Counts one place on, then starts, which are moved on as rows are written: they end as they shall be.
    for_each([&](std::size_t index, std::size_t, std::size_t) { ++first[index + 1]; });
    for (std::size_t index = 0; index + 1 < first.size(); ++index) first[index + 1] += first[index];
    row.resize(count);
    value.resize(count + converted_at_a_time);
    for_each([&](std::size_t index, std::size_t r, std::size_t i) {
        const std::uint32_t place = first[index]++;
        row[place] = static_cast<std::uint16_t>(r);
        value[place] = vectors.value[i];
    });
    std::move_backward(first.begin(), first.end() - 1, first.end());
    first[0] = 0;
}

std::size_t SparseColumns::bytes() const {
    return first.size() * sizeof first[0] + (row.size() + value.size()) * sizeof row[0] +
           scale.size() * sizeof scale[0];
}

FewCoefficients largest_coefficients(const DenseCoefficients& f, const CoefficientSpectrum& spectrum,
                                     float error) {
    const BlockNumbers numbers(f.face_size);
    std::vector<std::pair<double, std::uint32_t>> energies;
    double left_out = 0;
    for (int level = 0; level < numbers.levels(); ++level)
        for (std::size_t block = numbers(level, 0, 0); block < numbers(level, cubemap_faces, 0); ++block)
            for (std::size_t slot = 0; slot < wide_cells; ++slot) {
                const std::size_t index = block * wide_cells + slot;
                const auto& [red, green, blue, unused] = f.values[index];
                if (red == 0 && green == 0 && blue == 0) continue;
                const double matters = spectrum[spectrum_place(level, slot)];
                const double energy =
                    (double(red) * red + double(green) * green + double(blue) * blue) * (matters * matters);
                energies.emplace_back(energy, static_cast<std::uint32_t>(index));
                left_out += energy;
            }
    const double allowed = left_out * (double(error) * double(error));
    std::sort(energies.begin(), energies.end(), std::greater<>());
    std::size_t kept = 0;
    while (kept < energies.size() && left_out > allowed) left_out -= energies[kept++].first;
    FewCoefficients result;
    for (std::size_t k = 0; k < kept; ++k) result.index.push_back(energies[k].second);
    std::sort(result.index.begin(), result.index.end());
    for (const std::uint32_t index : result.index) result.value.push_back(f.values[index]);
    return result;
}

void add_inner_products(const SparseColumns& vectors, const FewCoefficients& f,
                        std::span<std::array<float, 4>> sums) {
    assert(sums.size() == vectors.scale.size());
    HWY_DYNAMIC_DISPATCH(add_columns)(vectors, f, sums.data());
}

}  // namespace haarfield
#endif
