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

/// A product with, by level of blocks and slot, what turns a square of its amplitudes into an energy.
struct MeasuredProduct {
    std::span<const WaveletBlock<3>> blocks;
    const std::uint8_t* levels;
    const ProductPruning::Slots* weights;
};

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Writes the energies of one block, and keeps them if they are not all zero.
HWY_INLINE void add_energies(const Cells& energy, std::size_t place, ProductPruning::Energies& to) {
    store_cells(energy, to.energy[to.blocks].data());
    to.place[to.blocks] = static_cast<std::uint32_t>(place);
    to.blocks += cells_above(energy, 0) != 0;
}

/// Energies of each channel.
void measure_channels(const MeasuredProduct& product, ProductPruning::Energies* energies) {
    Cells sums[3];
    for (Cells& sum : sums) sum = all_cells(0);
    for (std::size_t i = 0; i < product.blocks.size(); ++i) {
        const Cells weight = load_cells(product.weights[product.levels[i]].data());
        for (std::size_t c = 0; c < 3; ++c) {
            const Cells amplitude = load_cells(product.blocks[i].amplitude[c].data());
            const Cells energy = amplitude * amplitude * weight;
            sums[c] = sums[c] + energy;
            add_energies(energy, i, energies[c]);
        }
    }
    for (std::size_t c = 0; c < 3; ++c) energies[c].sum = double(sum_of(sums[c]));
}

/// Energies summed over the channels.
void measure_rgb(const MeasuredProduct& product, ProductPruning::Energies* energies) {
    Cells sum = all_cells(0);
    for (std::size_t i = 0; i < product.blocks.size(); ++i) {
        const auto& amplitude = product.blocks[i].amplitude;
        Cells energy = all_cells(0);
        for (const auto& channel : amplitude) {
            const Cells value = load_cells(channel.data());
            energy = multiply_add(value, value, energy);
        }
        energy = energy * load_cells(product.weights[product.levels[i]].data());
        sum = sum + energy;
        add_energies(energy, i, energies[0]);
    }
    energies[0].sum = double(sum_of(sum));
}

/// Sum of the energies that are not above a limit.
float energy_below(const ProductPruning::Energies& energies, float limit) {
    // Two sums, lest each addition wait for the one before.
    Cells even = all_cells(0), odd = even;
    std::size_t i = 0;
    for (; i + 2 <= energies.blocks; i += 2) {
        even = even + only_up_to(limit, load_cells(energies.energy[i].data()));
        odd = odd + only_up_to(limit, load_cells(energies.energy[i + 1].data()));
    }
    if (i < energies.blocks) even = even + only_up_to(limit, load_cells(energies.energy[i].data()));
    return sum_of(even + odd);
}

/// For each block, the cells whose energy is above a limit.
void mark_above(const ProductPruning::Energies& energies, float limit, std::uint16_t* marks) {
    for (std::size_t i = 0; i < energies.blocks; ++i)
        marks[i] = static_cast<std::uint16_t>(cells_above(load_cells(energies.energy[i].data()), limit));
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(measure_channels);
HWY_EXPORT(measure_rgb);
HWY_EXPORT(energy_below);
HWY_EXPORT(mark_above);

namespace {

/// The largest limit that leaves out no more than is allowed, to an eighth of its size.
///
/// If each energy is below its even share, all of them are within what is allowed; and one that is larger
/// than all that is allowed must be kept. Between the two the range of bits, which are in the order of
/// floats, is halved.
float energy_limit(const ProductPruning::Energies& energies, double allowed) {
    const auto limit_bits = [](double limit) {
        return std::bit_cast<std::uint32_t>(static_cast<float>(std::min(limit, 1e38)));
    };
    const auto count = double(energies.blocks * wide_cells);
    std::uint32_t low = limit_bits(allowed / (count + 1)), high = limit_bits(allowed);
    while (high - low > 1u << 20) {
        const std::uint32_t middle = low + (high - low) / 2;
        const float below = HWY_DYNAMIC_DISPATCH(energy_below)(energies, std::bit_cast<float>(middle));
        (double(below) <= allowed ? low : high) = middle;
    }
    return std::bit_cast<float>(low);
}

}  // namespace

ProductPruning::ProductPruning(int face_size, const CoefficientSpectrum& spectrum)
    : face_size_(face_size), numbers_(face_size) {
    for (int level = 0; level < 4; ++level)
        for (std::size_t slot = 0; slot < wide_cells; ++slot) {
            const float of_amplitude = coefficient_of_amplitude(level, slot),
                        matters = of_amplitude * spectrum[spectrum_place(level, slot)];
            normalisation_[std::size_t(level)][slot] = of_amplitude;
            weights_[std::size_t(level)][slot] = matters * matters;
        }
}

void ProductPruning::take(std::span<const WaveletBlock<3>> product) {
    product_ = product;
    levels_.resize(product.size());
    for (std::size_t i = 0; i < product.size(); ++i)
        levels_[i] = static_cast<std::uint8_t>(level_of_block(numbers_, product[i].block));
    for (Energies& energies : energies_) {
        if (energies.place.size() < product.size() + 1) {
            energies.energy.resize(product.size() + 1);
            energies.place.resize(product.size() + 1);
        }
        energies.blocks = 0;
        energies.sum = 0;
    }
}

void ProductPruning::take_channels(std::span<const WaveletBlock<3>> product) {
    take(product);
    HWY_DYNAMIC_DISPATCH(measure_channels)({product_, levels_.data(), weights_.data()}, energies_.data());
}

void ProductPruning::take_rgb(std::span<const WaveletBlock<3>> product) {
    take(product);
    HWY_DYNAMIC_DISPATCH(measure_rgb)({product_, levels_.data(), weights_.data()}, energies_.data());
}

Rgb ProductPruning::integral() const {
    Rgb sum(0.0f);
    for (std::size_t i = 0; i < product_.size(); ++i)
        if (levels_[i] == 0)
            for (std::size_t c = 0; c < 3; ++c) sum[int(c)] += product_[i].amplitude[c][0];
    return sum;
}

template <int channels>
void ProductPruning::append(std::size_t first_channel, const Energies& energies, double allowed,
                            SparseVectors& to) {
    assert(to.channels == channels && to.face_size == face_size_);
    const float limit = energy_limit(energies, allowed);
    marks_.resize(std::max(marks_.size(), energies.blocks));
    HWY_DYNAMIC_DISPATCH(mark_above)(energies, limit, marks_.data());
    std::size_t count = 0;
    for (std::size_t i = 0; i < energies.blocks; ++i) count += std::size_t(std::popcount(marks_[i]));
    kept_index_.resize(count);
    kept_value_.resize(count * channels);
    std::uint32_t* index = kept_index_.data();
    float* value = kept_value_.data();
    for (std::size_t i = 0; i < energies.blocks; ++i) {
        const WaveletBlock<3>& block = product_[energies.place[i]];
        const Slots& normalisation = normalisation_[levels_[energies.place[i]]];
        for (unsigned left = marks_[i]; left != 0; left &= left - 1) {
            const auto slot = static_cast<std::uint32_t>(std::countr_zero(left));
            *index++ = block.block * static_cast<std::uint32_t>(wide_cells) + slot;
            for (std::size_t c = 0; c < channels; ++c)
                *value++ = block.amplitude[first_channel + c][slot] * normalisation[slot];
        }
    }
    to.append(kept_index_, kept_value_);
}

void ProductPruning::append_channel(std::size_t channel, double allowed, SparseVectors& to) {
    append<1>(channel, energies_[channel], allowed, to);
}

void ProductPruning::append_rgb(double allowed, SparseVectors& to) {
    append<3>(0, energies_[0], allowed, to);
}

}  // namespace haarfield
#endif
