#include "shading/product_pruning.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/product_pruning.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/cells-inl.h"

#ifndef HAARFIELD_PRODUCT_PRUNING_ONCE
#define HAARFIELD_PRODUCT_PRUNING_ONCE

namespace haarfield {

/// One block's numbers, from amplitudes to energies. By channel; the last energy is the sum.
struct PrunedBlock {
    const float* amplitude[3];
    float* value[3];
    float* energy[4];
    const float* normalisation;
    const float* weight;
};

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Fills values and energies of blocks, and adds up energies by channel.
void measure(std::span<const PrunedBlock> blocks, double* energies) {
    Cells sums[3];
    for (Cells& sum : sums) sum = all_cells(0);
    for (const PrunedBlock& block : blocks) {
        const Cells normalisation = load_cells(block.normalisation), weight = load_cells(block.weight);
        Cells together = all_cells(0);
        for (int c = 0; c < 3; ++c) {
            const Cells value = load_cells(block.amplitude[c]) * normalisation;
            const Cells energy = value * value * weight;
            store_cells(value, block.value[c]);
            store_cells(energy, block.energy[c]);
            together = together + energy;
            sums[c] = sums[c] + energy;
        }
        store_cells(together, block.energy[3]);
    }
    for (int c = 0; c < 3; ++c) energies[c] = double(sum_of(sums[c]));
}

float energy_below(const float* energies, std::size_t count, float limit) {
    Cells sum = all_cells(0);
    for (std::size_t i = 0; i < count; i += wide_cells) {
        const Cells energy = load_cells(energies + i);
        sum = sum + only(~cells_above(energy, limit), energy);
    }
    return sum_of(sum);
}

/// For each block, the cells whose energy is above a limit.
void mark_above(const float* energies, std::size_t count, float limit, std::uint16_t* marks) {
    for (std::size_t i = 0; i < count; i += wide_cells)
        *marks++ = static_cast<std::uint16_t>(cells_above(load_cells(energies + i), limit));
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(measure);
HWY_EXPORT(energy_below);
HWY_EXPORT(mark_above);

namespace {

/// The largest limit that leaves out no more than is allowed, to an eighth of its size.
///
/// If each energy is below its even share, all of them are within what is allowed; and one that is larger
/// than all that is allowed must be kept. Between the two the range of bits, which are in the order of
/// floats, is halved.
float energy_limit(const float* energies, std::size_t count, double allowed) {
    const auto limit_bits = [](double limit) {
        return std::bit_cast<std::uint32_t>(static_cast<float>(std::min(limit, 1e38)));
    };
    std::uint32_t low = limit_bits(allowed / double(count + 1)), high = limit_bits(allowed);
    while (high - low > 1u << 20) {
        const std::uint32_t middle = low + (high - low) / 2;
        const float below = HWY_DYNAMIC_DISPATCH(energy_below)(energies, count, std::bit_cast<float>(middle));
        (double(below) <= allowed ? low : high) = middle;
    }
    return std::bit_cast<float>(low);
}

}  // namespace

ProductPruning::ProductPruning(int face_size, const CoefficientSpectrum& spectrum)
    : face_size_(face_size), numbers_(face_size) {
    for (int level = 0; level < 4; ++level)
        for (std::size_t slot = 0; slot < wide_cells; ++slot) {
            const float s = spectrum[spectrum_place(level, slot)];
            weights_[std::size_t(level)][slot] = s * s;
            normalisation_[std::size_t(level)][slot] = coefficient_of_amplitude(level, slot);
        }
}

ProductPruning::~ProductPruning() = default;

void ProductPruning::take(std::span<const WaveletBlock<3>> product) {
    const std::size_t count = product.size();
    blocks_.resize(count);
    for (auto& values : values_) values.resize(count);
    for (auto& energy : energy_) energy.resize(count);
    work_.resize(count);
    integral_ = Rgb(0.0f);
    for (std::size_t i = 0; i < count; ++i) {
        const WaveletBlock<3>& from = product[i];
        blocks_[i] = from.block;
        const auto level = static_cast<std::size_t>(level_of_block(numbers_, from.block));
        for (std::size_t c = 0; c < 3; ++c) {
            work_[i].amplitude[c] = from.amplitude[c].data();
            work_[i].value[c] = values_[c][i].data();
            if (level == 0) integral_[int(c)] += from.amplitude[c][0];
        }
        for (std::size_t c = 0; c < 4; ++c) work_[i].energy[c] = energy_[c][i].data();
        work_[i].normalisation = normalisation_[level].data();
        work_[i].weight = weights_[level].data();
    }
    HWY_DYNAMIC_DISPATCH(measure)(work_, energies_.data());
}

template <int channels>
void ProductPruning::append(std::size_t first_channel, double allowed, SparseVectors& to) {
    assert(to.channels == channels && to.face_size == face_size_);
    const std::size_t count = blocks_.size() * wide_cells;
    const float* energies = count > 0 ? energy_[channels == 1 ? first_channel : 3][0].data() : nullptr;
    const float limit = energy_limit(energies, count, allowed);
    marks_.resize(blocks_.size());
    HWY_DYNAMIC_DISPATCH(mark_above)(energies, count, limit, marks_.data());
    kept_index_.clear();
    kept_value_.clear();
    for (std::size_t i = 0; i < blocks_.size(); ++i)
        for (unsigned left = marks_[i]; left != 0; left &= left - 1) {
            const auto slot = static_cast<std::uint32_t>(std::countr_zero(left));
            kept_index_.push_back(blocks_[i] * static_cast<std::uint32_t>(wide_cells) + slot);
            for (std::size_t c = 0; c < channels; ++c)
                kept_value_.push_back(values_[first_channel + c][i][slot]);
        }
    to.append(kept_index_, kept_value_);
}

void ProductPruning::append_channel(std::size_t channel, double allowed, SparseVectors& to) {
    append<1>(channel, allowed, to);
}

void ProductPruning::append_rgb(double allowed, SparseVectors& to) {
    append<3>(0, allowed, to);
}

}  // namespace haarfield
#endif
