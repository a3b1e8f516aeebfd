#pragma once
/// From function products of neighbouring vertices to grouped columns.

#include "shading/transfer/coefficient_energies.h"
#include "shading/transfer/grouped_columns.h"
#include "shading/walk/wavelet_blocks.h"

namespace haarfield {

/// Prunes the products of up to eight rows together: a coefficient is kept for all of them, or for none.
/// Each channel of the products is a group of its own. Keeps its memory from one group to the next.
///
/// cost  O(blocks): less than the walks that made them.
template <int channels>
class GroupPruning {
public:
    using Block = WaveletBlock<channels>;  ///< Of the product that is pruned.

    /// For functions on faces of a size, against others with such coefficients.
    GroupPruning(int face_size, const CoefficientSpectrum& spectrum);

    /// Forgets all rows.
    void clear();

    /// The product of a row, to be written by the caller; it counts once it has weights.
    std::vector<Block>& product(std::size_t row) { return rows_[row].product; }

    /// By channel: what a square of the row's energies (EnergyWeights) counts.
    void set_weights(std::size_t row, const std::array<float, channels>& weights);

    /// Appends one entry a coefficient that is kept of the rows and channels, and one scale a channel.
    ///
    /// error        the energies left out are at most error^2 of all.
    /// first_group  the number of the first channel's group; the others follow.
    void append(double error, std::size_t first_group, std::vector<std::uint32_t>& indices,
                std::vector<GroupEntry>& entries, std::vector<float>& scales);

    /// A row as the vector kernels see it.
    struct Row {
        std::vector<Block> product;
        std::array<float, channels> weights{};
    };
    /// What the rows have of one block.
    struct Shared {
        std::uint32_t block;
        std::uint16_t level;
        std::array<const Block*, group_rows> of_row;  ///< Null: zero.
    };

private:
    void share_blocks();

    EnergyWeights weights_;
    std::array<Row, group_rows> rows_;
    std::size_t row_end_ = 0;
    std::vector<Shared> shared_;
    std::vector<std::uint32_t> place_;  ///< In shared_, one on, by number of a block; 0: not there.
    CoefficientEnergies energies_;      ///< place: channels * place in shared_ + channel.
};

}  // namespace haarfield
