#include "shading/transfer/product_pruning.h"

#include <bit>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/transfer/product_pruning.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/walk/cells-inl.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Computes the energies of a product's blocks, summed over the channels. Returns the integral of the
/// product.
Rgb measure(std::span<const WaveletBlock<3>> product, const EnergyWeights& weights,
            CoefficientEnergies& energies) {
    Cells sum = all_cells(0);
    Rgb integral(0.0f);
    for (std::size_t i = 0; i < product.size(); ++i) {
        Cells energy = all_cells(0);
        for (const auto& channel : product[i].amplitude) {
            const Cells value = load_cells(channel.data());
            energy = multiply_add(value, value, energy);
        }
        if (product[i].level == 0)
            for (std::size_t c = 0; c < 3; ++c) integral[int(c)] += product[i].amplitude[c][0];
        energy = energy * load_cells(weights.weight[product[i].level].data());
        sum = sum + energy;
        store_cells(energy, energies.energy[energies.blocks].data());
        energies.place[energies.blocks] = static_cast<std::uint32_t>(i);
        energies.blocks += cells_above(energy, 0) != 0;
    }
    energies.sum = double(sum_of(sum));
    return integral;
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(measure);

ProductPruning::ProductPruning(int face_size, const CoefficientSpectrum& spectrum)
    : face_size_(face_size), weights_(spectrum) {}

void ProductPruning::take(std::span<const WaveletBlock<3>> product) {
    product_ = product;
    energies_.clear(product.size() + 1);
    integral_ = HWY_DYNAMIC_DISPATCH(measure)(product_, weights_, energies_);
}

void ProductPruning::append(double allowed, SparseVectors& to) {
    assert(to.channels == 3 && to.face_size == face_size_);
    const std::size_t count = energies_.mark(allowed);
    kept_index_.resize(count);
    kept_value_.resize(count * 3);
    std::uint32_t* index = kept_index_.data();
    float* value = kept_value_.data();
    for (std::size_t i = 0; i < energies_.blocks; ++i) {
        const WaveletBlock<3>& block = product_[energies_.place[i]];
        const SlotValues& normalisation = weights_.normalisation[block.level];
        for (unsigned left = energies_.marks[i]; left != 0; left &= left - 1) {
            const auto slot = static_cast<std::uint32_t>(std::countr_zero(left));
            *index++ = block.block * static_cast<std::uint32_t>(wide_cells) + slot;
            for (std::size_t c = 0; c < 3; ++c) *value++ = block.amplitude[c][slot] * normalisation[slot];
        }
    }
    to.append(kept_index_, kept_value_);
}

}  // namespace haarfield
#endif
