#pragma once
/// How much the coefficients of a product matter, and which of them can be left out.

#include "shading/transfer/sparse_vectors.h"

namespace haarfield {

/// A number for each slot of a block (WaveletBlock).
using SlotValues = std::array<float, wide_cells>;

/// By level of blocks and slot: from an amplitude to its coefficient, and from its square to an energy: the
/// square of the coefficient times that of the spectrum at its level, which is what it adds, on the average,
/// to the square of an inner product with a function whose coefficients are independent and as large as the
/// spectrum says.
struct EnergyWeights {
    std::array<SlotValues, 4> normalisation{}, weight{};

    explicit EnergyWeights(const CoefficientSpectrum& spectrum);  ///< Of functions with such coefficients.
};

/// A spectrum's weights of what lies below the cells of blocks, and the deviations whose energy in one cell
/// is at most so much.
DetailWeights detail_weights(const CoefficientSpectrum& spectrum, double energy_of_a_cell);

/// The energies of a list of blocks, as far as there are any. Keeps its memory from one list to the next.
struct CoefficientEnergies {
    std::vector<SlotValues> energy;
    std::vector<std::uint32_t> place;  ///< Of the block where it came from.
    std::vector<std::uint16_t> marks;  ///< Of each block, the slots that are kept.
    std::size_t blocks = 0;            ///< How many; the vectors are longer.
    double sum = 0;

    /// Forgets the blocks, and makes room for so many.
    void clear(std::size_t room);

    /// Marks what is left when the smallest are left out, as long as their energies together are at most what
    /// is allowed; the limit is found to an eighth of its size. Returns how many slots are marked.
    ///
    /// accuracy  sums differ by rounding between instruction sets, and so may what is left out.
    /// cost      O(blocks): some three passes if the limit is near that of the last list.
    std::size_t mark(double allowed);

private:
    std::uint32_t last_distance_ = 1;  ///< Of the last limit from what was allowed, in places of the grid.
};

}  // namespace haarfield
