#pragma once
/// From function products to sparse vectors: coefficients that matter little are left out.

#include "shading/transfer/coefficient_energies.h"
#include "shading/walk/wavelet_blocks.h"

namespace haarfield {

/// Prunes one RGB product at a time by what it will be multiplied with. Keeps its memory: nothing is
/// allocated per product once it has grown.
///
/// cost      O(blocks): less than the walk that made them.
class ProductPruning {
public:
    /// For products on faces of a size, against functions with such coefficients.
    ProductPruning(int face_size, const CoefficientSpectrum& spectrum);

    /// Takes up a product (wavelet_blocks.h), which must outlive what is appended from it.
    void take(std::span<const WaveletBlock<3>> product);

    /// Of the product at hand: the sum of all energies (EnergyWeights), over the channels.
    double energy() const { return energies_.sum; }

    /// Of the product at hand: the integral over the faces, by channel.
    Rgb integral() const { return integral_; }

    /// Appends the product to RGB vectors, without what CoefficientEnergies::mark leaves out.
    void append(double allowed, SparseVectors& to);

private:
    int face_size_;
    EnergyWeights weights_;
    std::span<const WaveletBlock<3>> product_;
    Rgb integral_{0.0f};
    CoefficientEnergies energies_;
    std::vector<std::uint32_t> kept_index_;
    std::vector<float> kept_value_;
};

}  // namespace haarfield
