#pragma once
/// From function products to sparse vectors: coefficients that matter little are left out.

#include "shading/sparse_vectors.h"
#include "shading/wide_product.h"

namespace haarfield {

/// Prunes one product at a time by what it will be multiplied with. Keeps its memory: nothing is allocated
/// per product once it has grown.
///
/// A coefficient's energy is its square times the square of the spectrum at its level: what it adds, on the
/// average, to the square of an inner product with a function whose coefficients are independent and as large
/// as the spectrum says. The smallest are left out as long as their energies together are at most what is
/// allowed; the limit is found to an eighth of its size.
///
/// accuracy  energies differ by rounding between instruction sets, and so may what is left out.
/// cost      O(blocks): less than the walk that made them.
class ProductPruning {
public:
    ProductPruning(int face_size, const CoefficientSpectrum& spectrum);

    /// Takes up a product (wide_product.h), which must outlive what is appended from it.
    /// @{
    void take_channels(std::span<const WaveletBlock<3>> product);  ///< For append_channel.
    void take_rgb(std::span<const WaveletBlock<3>> product);       ///< For append_rgb.
    /// @}

    /// Of the product at hand: the sum of all energies, of a channel after take_channels, and of all of them
    /// after take_rgb.
    double channel_energy(std::size_t channel) const { return energies_[channel].sum; }
    double rgb_energy() const { return energies_[0].sum; }

    /// Of the product at hand: the integral over the faces, by channel.
    Rgb integral() const;

    /// Appends one channel of the product to vectors of one channel,
    void append_channel(std::size_t channel, double allowed, SparseVectors& to);
    /// or all three to RGB vectors; a coefficient's energy is then the sum over the channels.
    void append_rgb(double allowed, SparseVectors& to);

    using Slots = std::array<float, wide_cells>;

    /// Energies of those of a product's blocks that have any.
    struct Energies {
        std::vector<Slots> energy;
        std::vector<std::uint32_t> place;  ///< Of the block in the product.
        std::size_t blocks = 0;            ///< How many; the vectors are longer.
        double sum = 0;
    };

private:
    void take(std::span<const WaveletBlock<3>> product);
    template <int channels>
    void append(std::size_t first_channel, const Energies& energies, double allowed, SparseVectors& to);

    int face_size_;
    BlockNumbers numbers_;
    std::array<Slots, 4> normalisation_, weights_;  ///< By level of blocks and slot; see sparse_vectors.h.

    std::span<const WaveletBlock<3>> product_;
    std::vector<std::uint8_t> levels_;  ///< Of the product's blocks.
    std::array<Energies, 3> energies_;  ///< By channel, or the first one of all.
    std::vector<std::uint16_t> marks_;  ///< By block that has energy: the slots that are kept.
    std::vector<std::uint32_t> kept_index_;
    std::vector<float> kept_value_;
};

}  // namespace haarfield
