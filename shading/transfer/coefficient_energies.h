#pragma once
/// Energies of the coefficients of a product, and the selection of those to be dropped.

#include "shading/transfer/sparse_vectors.h"

namespace haarfield {

/// One number for each slot of a block (WaveletBlock).
using SlotValues = std::array<float, wide_cells>;

/// Factors by level of blocks and slot: from an amplitude to its coefficient, and from its square to an
/// energy. The energy of a coefficient is its square times the squared spectrum at its level. It is the
/// expected contribution to the square of an inner product with a function whose coefficients are independent
/// and have the spectrum's magnitudes.
struct EnergyWeights {
    std::array<SlotValues, 4> normalisation{}, weight{};

    explicit EnergyWeights(const CoefficientSpectrum& spectrum);  ///< For functions with this spectrum.
};

/// Returns the spectrum's weights for details below the cells of blocks, and the deviations whose energy in
/// one cell is at most `energy_of_a_cell`.
DetailWeights detail_weights(const CoefficientSpectrum& spectrum, double energy_of_a_cell);

/// The nonzero energies of a list of blocks. Reuses its memory between lists.
struct CoefficientEnergies {
    std::vector<SlotValues> energy;
    std::vector<std::uint32_t> place;  ///< Index of the block that each entry belongs to.
    std::vector<std::uint16_t> marks;  ///< By entry, the slots to be kept.
    std::size_t blocks = 0;            ///< Number of entries; the vectors are longer.
    double sum = 0;

    /// Removes all blocks, and reserves memory.
    void clear(std::size_t room);

    /// Marks the slots that remain after the smallest are dropped, as long as the sum of the dropped energies
    /// is at most `allowed`. The limit is found to an eighth of its size. Returns the number of marked slots.
    ///
    /// accuracy  sums differ between instruction sets by rounding, and the selection may differ accordingly.
    /// cost      O(blocks): about three passes if the limit is close to that of the last list.
    std::size_t mark(double allowed);

private:
    std::uint32_t last_distance_ = 1;  ///< Distance of the last limit from `allowed`, in grid steps.
};

}  // namespace haarfield
