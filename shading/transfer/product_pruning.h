#pragma once
/// Converts function products to sparse vectors, dropping unimportant coefficients.

#include "shading/transfer/coefficient_energies.h"
#include "shading/walk/wavelet_blocks.h"

namespace haarfield {

/// Prunes one RGB product at a time by the spectrum of its future factor. Reuses its memory: allocates
/// nothing per product once it has grown.
///
/// cost      O(blocks): less than the walk that made them.
class ProductPruning {
public:
    /// For products on faces of a size, multiplied by functions with this spectrum.
    ProductPruning(int face_size, const CoefficientSpectrum& spectrum);

    /// Sets the current product (wavelet_blocks.h), which must outlive the calls of append.
    void take(std::span<const WaveletBlock<3>> product);

    /// Returns the sum of all energies (EnergyWeights) of the current product, over the channels.
    double energy() const { return energies_.sum; }

    /// Returns the integral of the current product over the faces, by channel.
    Rgb integral() const { return integral_; }

    /// Appends the current product to RGB vectors, without the coefficients that CoefficientEnergies::mark
    /// drops.
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
