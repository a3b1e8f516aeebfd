#include "shading/transfer/grouped_columns.h"

#include <algorithm>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/transfer/grouped_columns.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Eight lanes on all machines and no fused multiply-add: results are bit-identical everywhere.
using Floats = hn::CappedTag<float, group_rows>;
using Words = hn::RebindToSigned<Floats>;
using Bytes = hn::Rebind<std::int8_t, Floats>;

void add_columns(const GroupedColumns& vectors, const SelectedCoefficients& f, GroupSums* sums) {
    constexpr std::size_t entries_ahead = 4, starts_ahead = 12;
    const std::size_t lanes = hn::Lanes(Floats()), count = f.index.size();
    const std::uint32_t* first = vectors.first.data();
    const GroupEntry* entry = vectors.entry.data();
    for (std::size_t k = 0; k < count; ++k) {
        // Columns are far apart in memory: prefetches them.
        if (k + starts_ahead < count) hwy::Prefetch(first + f.index[k + starts_ahead]);
        if (k + entries_ahead < count) hwy::Prefetch(entry + first[f.index[k + entries_ahead]]);
        const auto red = hn::Set(Floats(), f.value[k][0]), green = hn::Set(Floats(), f.value[k][1]),
                   blue = hn::Set(Floats(), f.value[k][2]);
        const std::size_t end = first[f.index[k] + 1];
        for (std::size_t i = first[f.index[k]]; i < end; ++i) {
            auto& [red_sum, green_sum, blue_sum] = sums[entry[i].group];
            const auto step = hn::Set(Floats(), entry_step(entry[i].exponent));
            for (std::size_t lane = 0; lane < group_rows; lane += lanes) {
                const auto bytes = hn::LoadU(Bytes(), entry[i].value.data() + lane);
                const auto value = hn::Mul(hn::ConvertTo(Floats(), hn::PromoteTo(Words(), bytes)), step);
                const auto add = [&](const auto& factor, std::array<float, group_rows>& sum) {
                    const auto before = hn::LoadU(Floats(), sum.data() + lane);
                    hn::StoreU(hn::Add(before, hn::Mul(value, factor)), Floats(), sum.data() + lane);
                };
                add(red, red_sum);
                add(green, green_sum);
                add(blue, blue_sum);
            }
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(add_columns);

GroupedColumns::GroupedColumns(int face_size, std::span<const std::uint32_t> indices,
                               std::span<const GroupEntry> entries, std::vector<float> scales)
    : first(coefficient_count(face_size) + 1, 0), entry(entries.size()), scale(std::move(scales)) {
    assert(indices.size() == entries.size() && scale.size() <= most_groups);
    // Counts are stored one place later and summed to starts, which advance as entries are written. They are
    // then ends, and are moved back by one place.
    for (const std::uint32_t index : indices) ++first[index + 1];
    for (std::size_t index = 0; index + 1 < first.size(); ++index) first[index + 1] += first[index];
    for (std::size_t i = 0; i < entries.size(); ++i) entry[first[indices[i]]++] = entries[i];
    std::move_backward(first.begin(), first.end() - 1, first.end());
    first[0] = 0;
}

std::size_t GroupedColumns::bytes() const {
    return first.size() * sizeof first[0] + entry.size() * sizeof entry[0] + scale.size() * sizeof scale[0];
}

SelectedCoefficients largest_coefficients(const DenseCoefficients& f, const CoefficientSpectrum& spectrum,
                                          float error) {
    const BlockNumbers numbers(f.face_size);
    std::vector<double> energies;
    std::vector<std::uint32_t> indices;
    for (int level = 0; level < numbers.levels(); ++level)
        for (std::size_t block = numbers(level, 0, 0); block < numbers(level, cubemap_faces, 0); ++block)
            for (std::size_t slot = 0; slot < wide_cells; ++slot) {
                const std::size_t index = block * wide_cells + slot;
                const auto& [red, green, blue, unused] = f.values[index];
                if (red == 0 && green == 0 && blue == 0) continue;
                const double matters = spectrum[spectrum_place(level, slot)];
                energies.push_back(squared(Rgb(red, green, blue)) * (matters * matters));
                indices.push_back(static_cast<std::uint32_t>(index));
            }
    SelectedCoefficients result;
    for (const std::uint32_t k : largest_energies(energies, error)) result.index.push_back(indices[k]);
    std::sort(result.index.begin(), result.index.end());
    for (const std::uint32_t index : result.index) result.value.push_back(f.values[index]);
    return result;
}

void add_inner_products(const GroupedColumns& vectors, const SelectedCoefficients& f,
                        std::span<GroupSums> sums) {
    assert(sums.size() == vectors.scale.size());
    HWY_DYNAMIC_DISPATCH(add_columns)(vectors, f, sums.data());
}

}  // namespace haarfield
#endif
