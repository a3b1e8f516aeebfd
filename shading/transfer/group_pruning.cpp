#include "shading/transfer/group_pruning.h"

#include <algorithm>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/transfer/group_pruning.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/walk/cells-inl.h"

#ifndef HAARFIELD_GROUP_PRUNING_ONCE
#define HAARFIELD_GROUP_PRUNING_ONCE

namespace haarfield {

/// The slots of a block for all rows, as exponents and bytes (GroupEntry).
struct QuantisedBlock {
    std::array<std::int32_t, wide_cells> exponent;
    std::array<std::array<std::int8_t, group_rows>, wide_cells> value;
};

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Returns the energies of a channel of a block, summed over the rows. Updates `largest`, the largest
/// magnitude of a coefficient.
template <int channels>
HWY_INLINE Cells shared_energy(const typename GroupPruning<channels>::Shared& shared,
                               const std::array<typename GroupPruning<channels>::Row, group_rows>& rows,
                               std::size_t channel, const EnergyWeights& weights, Cells& largest) {
    Cells energy = all_cells(0), peak = all_cells(0);
    for (std::size_t r = 0; r < group_rows; ++r) {
        if (!shared.of_row[r]) continue;
        const Cells value = load_cells(shared.of_row[r]->amplitude[channel].data());
        energy = multiply_add(value * value, all_cells(rows[r].weights[channel]), energy);
        peak = larger(peak, magnitude(value));
    }
    largest = larger(largest, peak * load_cells(weights.normalisation[shared.level].data()));
    return energy * load_cells(weights.weight[shared.level].data());
}

float largest_of(const Cells& cells) {
    alignas(64) float cell[wide_cells];
    store_cells(cells, cell);
    return *std::max_element(cell, cell + wide_cells);
}

template <int channels>
void measure(std::span<const typename GroupPruning<channels>::Shared> shared,
             const std::array<typename GroupPruning<channels>::Row, group_rows>& rows,
             const EnergyWeights& weights, CoefficientEnergies& energies, float* largest) {
    Cells sum = all_cells(0), peak[channels];
    for (Cells& of_channel : peak) of_channel = all_cells(0);
    for (std::size_t i = 0; i < shared.size(); ++i)
        for (std::size_t c = 0; c < channels; ++c) {
            const Cells energy = shared_energy<channels>(shared[i], rows, c, weights, peak[c]);
            sum = sum + energy;
            store_cells(energy, energies.energy[energies.blocks].data());
            energies.place[energies.blocks] = static_cast<std::uint32_t>(i * channels + c);
            energies.blocks += cells_above(energy, 0) != 0;
        }
    energies.sum = double(sum_of(sum));
    for (std::size_t c = 0; c < channels; ++c) largest[c] = largest_of(peak[c]);
}

/// Transposes bytes from row order to slot order.
HWY_INLINE void transpose(const std::array<std::array<std::int8_t, wide_cells>, group_rows>& by_row,
                          std::array<std::array<std::int8_t, group_rows>, wide_cells>& by_slot) {
#if HWY_TARGET == HWY_SCALAR
    for (std::size_t r = 0; r < group_rows; ++r)
        for (std::size_t slot = 0; slot < wide_cells; ++slot) by_slot[slot][r] = by_row[r][slot];
#else
    static_assert(group_rows == 8);
    const hn::Full128<std::int8_t> bytes;
    const hn::Full128<std::int16_t> pairs;
    const hn::Full128<std::int32_t> fours;
    hn::Vec<decltype(bytes)> row[group_rows];
    for (std::size_t r = 0; r < group_rows; ++r) row[r] = hn::LoadU(bytes, by_row[r].data());
    const auto lower = [](const auto& d, const auto& a, const auto& b) {
        return hn::InterleaveLower(d, hn::BitCast(d, a), hn::BitCast(d, b));
    };
    const auto upper = [](const auto& d, const auto& a, const auto& b) {
        return hn::InterleaveUpper(d, hn::BitCast(d, a), hn::BitCast(d, b));
    };
    std::size_t slot = 0;
    const auto store_two = [&](const auto& slots) {
        hn::StoreU(hn::BitCast(bytes, slots), bytes, by_slot[slot].data());
        slot += 2;
    };
    const auto join = [&](const auto& rows_01, const auto& rows_23, const auto& rows_45,
                          const auto& rows_67) {
        const auto first_03 = lower(pairs, rows_01, rows_23), second_03 = upper(pairs, rows_01, rows_23),
                   first_47 = lower(pairs, rows_45, rows_67), second_47 = upper(pairs, rows_45, rows_67);
        store_two(lower(fours, first_03, first_47));
        store_two(upper(fours, first_03, first_47));
        store_two(lower(fours, second_03, second_47));
        store_two(upper(fours, second_03, second_47));
    };
    join(lower(bytes, row[0], row[1]), lower(bytes, row[2], row[3]), lower(bytes, row[4], row[5]),
         lower(bytes, row[6], row[7]));
    join(upper(bytes, row[0], row[1]), upper(bytes, row[2], row[3]), upper(bytes, row[4], row[5]),
         upper(bytes, row[6], row[7]));
#endif
}

/// inverse_scale  of the group's largest coefficient.
template <int channels>
void quantise(const typename GroupPruning<channels>::Shared& shared, std::size_t channel,
              const EnergyWeights& weights, float inverse_scale, QuantisedBlock& to) {
    using Words = hn::RebindToSigned<Floats>;
    const hn::Rebind<std::int8_t, Floats> bytes;
    const Cells normalisation =
        load_cells(weights.normalisation[shared.level].data()) * all_cells(inverse_scale);
    Cells peak = all_cells(0);
    for (const auto* block : shared.of_row)
        if (block) peak = larger(peak, magnitude(load_cells(block->amplitude[channel].data())));
    peak = peak * normalisation;
    Cells factor;
    for (std::size_t i = 0; i < parts; ++i) {
        // Rounds up to the next step; a value that exceeds the largest by rounding is limited to it.
        const auto bits =
            hn::Add(hn::BitCast(Words(), peak.part[i]), hn::Set(Words(), (1 << step_shift) - 1));
        const auto exponent = hn::Min(
            hn::Max(hn::Sub(hn::ShiftRight<step_shift>(bits), hn::Set(Words(), std::int32_t(first_step))),
                    hn::Zero(Words())),
            hn::Set(Words(), 255));
        hn::StoreU(exponent, Words(), to.exponent.data() + i * cells_per_part);
        const auto step = hn::BitCast(Floats(), hn::ShiftLeft<step_shift>(hn::Add(
                                                    exponent, hn::Set(Words(), std::int32_t(first_step)))));
        factor.part[i] = hn::Div(hn::Set(Floats(), 127.0f), step);
    }
    factor = factor * normalisation;
    std::array<std::array<std::int8_t, wide_cells>, group_rows> by_row;
    for (std::size_t r = 0; r < group_rows; ++r) {
        const auto* block = shared.of_row[r];
        const Cells value = block ? load_cells(block->amplitude[channel].data()) * factor : all_cells(0);
        for (std::size_t i = 0; i < parts; ++i)
            hn::StoreU(hn::DemoteTo(bytes, hn::NearestInt(value.part[i])), bytes,
                       by_row[r].data() + i * cells_per_part);
    }
    transpose(by_row, to.value);
}

void measure_two(std::span<const GroupPruning<2>::Shared> shared,
                 const std::array<GroupPruning<2>::Row, group_rows>& rows, const EnergyWeights& weights,
                 CoefficientEnergies& energies, float* largest) {
    measure<2>(shared, rows, weights, energies, largest);
}
void measure_three(std::span<const GroupPruning<3>::Shared> shared,
                   const std::array<GroupPruning<3>::Row, group_rows>& rows, const EnergyWeights& weights,
                   CoefficientEnergies& energies, float* largest) {
    measure<3>(shared, rows, weights, energies, largest);
}
void quantise_two(const GroupPruning<2>::Shared& shared, std::size_t channel, const EnergyWeights& weights,
                  float inverse_scale, QuantisedBlock& to) {
    quantise<2>(shared, channel, weights, inverse_scale, to);
}
void quantise_three(const GroupPruning<3>::Shared& shared, std::size_t channel, const EnergyWeights& weights,
                    float inverse_scale, QuantisedBlock& to) {
    quantise<3>(shared, channel, weights, inverse_scale, to);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(measure_two);
HWY_EXPORT(measure_three);
HWY_EXPORT(quantise_two);
HWY_EXPORT(quantise_three);

template <int channels>
GroupPruning<channels>::GroupPruning(int face_size, const CoefficientSpectrum& spectrum)
    : weights_(spectrum), place_(BlockNumbers(face_size).count(), 0) {}

template <int channels>
void GroupPruning<channels>::clear() {
    for (Row& row : rows_) row.weights.fill(0);
    row_end_ = 0;
}

template <int channels>
void GroupPruning<channels>::set_weights(std::size_t row, const std::array<float, channels>& weights) {
    assert(row < group_rows);
    for (; row_end_ <= row; ++row_end_)
        if (row_end_ < row) rows_[row_end_].product.clear();
    rows_[row].weights = weights;
}

/// Lists the blocks that at least one row has.
template <int channels>
void GroupPruning<channels>::share_blocks() {
    shared_.clear();
    for (std::size_t r = 0; r < row_end_; ++r)
        for (const Block& block : rows_[r].product) {
            std::uint32_t& place = place_[block.block];
            if (place == 0) {
                shared_.push_back({block.block, block.level, {}});
                place = static_cast<std::uint32_t>(shared_.size());
            }
            shared_[place - 1].of_row[r] = &block;
        }
    for (const Shared& shared : shared_) place_[shared.block] = 0;
}

template <int channels>
void GroupPruning<channels>::append(double error, std::size_t first_group,
                                    std::vector<std::uint32_t>& indices, std::vector<GroupEntry>& entries,
                                    std::vector<float>& scales) {
    share_blocks();
    energies_.clear(shared_.size() * channels + 1);
    std::array<float, channels> largest{};
    if constexpr (channels == 2)
        HWY_DYNAMIC_DISPATCH(measure_two)(shared_, rows_, weights_, energies_, largest.data());
    else
        HWY_DYNAMIC_DISPATCH(measure_three)(shared_, rows_, weights_, energies_, largest.data());
    const std::size_t count = energies_.mark(error * error * energies_.sum);
    std::size_t next = entries.size();
    indices.resize(next + count);
    entries.resize(next + count);
    QuantisedBlock quantised;
    for (std::size_t i = 0; i < energies_.blocks; ++i) {
        if (energies_.marks[i] == 0) continue;
        const Shared& shared = shared_[energies_.place[i] / channels];
        const std::size_t channel = energies_.place[i] % channels;
        const float inverse_scale = 1 / largest[channel];
        if constexpr (channels == 2)
            HWY_DYNAMIC_DISPATCH(quantise_two)(shared, channel, weights_, inverse_scale, quantised);
        else
            HWY_DYNAMIC_DISPATCH(quantise_three)(shared, channel, weights_, inverse_scale, quantised);
        for (unsigned left = energies_.marks[i]; left != 0; left &= left - 1, ++next) {
            const auto slot = static_cast<std::uint32_t>(std::countr_zero(left));
            indices[next] = shared.block * static_cast<std::uint32_t>(wide_cells) + slot;
            entries[next].group = static_cast<std::uint8_t>(first_group + channel);
            entries[next].exponent = static_cast<std::uint8_t>(quantised.exponent[slot]);
            entries[next].value = quantised.value[slot];
        }
    }
    for (const float of_channel : largest) scales.push_back(of_channel / 127);
}

template class GroupPruning<2>;
template class GroupPruning<3>;

}  // namespace haarfield
#endif
