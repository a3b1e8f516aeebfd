#pragma once
/// From function products to sparse vectors: coefficients that matter little are left out.

#include "shading/sparse_vectors.h"
#include "shading/wide_product.h"

namespace haarfield {

struct PrunedBlock;

/// Prunes one product at a time by what it will be multiplied with. Keeps its memory: nothing is allocated
/// per product once it has grown.
///
/// A coefficient's energy is its square times the square of the spectrum at its level: what it adds, on the
/// average, to the square of an inner product with a function whose coefficients are independent and as large
/// as the spectrum says. The smallest are left out as long as their energies together are at most what is
/// allowed; the limit is found to an eighth of its size.
///
/// accuracy  energies differ by rounding between instruction sets, and so may what is left out.
/// cost      O(blocks): about that of the walk that made them.
class ProductPruning {
public:
    ProductPruning(int face_size, const CoefficientSpectrum& spectrum);
    ~ProductPruning();

    /// Takes up a product (wide_product.h).
    void take(std::span<const WaveletBlock<3>> product);

    /// Of the product at hand: sum of all energies, by channel.
    const std::array<double, 3>& energies() const { return energies_; }

    /// Of the product at hand: the integral over the faces, by channel.
    Rgb integral() const { return integral_; }

    /// Appends one channel of the product to vectors of one channel,
    void append_channel(std::size_t channel, double allowed, SparseVectors& to);
    /// or all three to RGB vectors; a coefficient's energy is then the sum over the channels.
    void append_rgb(double allowed, SparseVectors& to);

private:
    template <int channels>
    void append(std::size_t first_channel, double allowed, SparseVectors& to);

    int face_size_;
    BlockNumbers numbers_;
    using Slots = std::array<float, wide_cells>;
    std::array<Slots, 4> normalisation_, weights_;  ///< By level of blocks and slot; see sparse_vectors.h.

    std::vector<std::uint32_t> blocks_;         ///< Numbers of the product's blocks.
    std::array<std::vector<Slots>, 3> values_;  ///< Coefficients by channel and block,
    std::array<std::vector<Slots>, 4> energy_;  ///< their energies; last the sums over the channels.
    std::array<double, 3> energies_{};
    Rgb integral_;
    std::vector<PrunedBlock> work_;
    std::vector<std::uint16_t> marks_;  ///< By block: the slots that are kept.
    std::vector<std::uint32_t> kept_index_;
    std::vector<float> kept_value_;
};

}  // namespace haarfield
