#pragma once
/// Converts function products of neighbouring vertices to grouped columns.

#include "shading/transfer/coefficient_energies.h"
#include "shading/transfer/grouped_columns.h"
#include "shading/walk/wavelet_blocks.h"

namespace haarfield {

/// Prunes the products of up to eight rows jointly: a coefficient is kept for all of them, or for none. Each
/// channel of the products is a separate group. Reuses its memory between groups.
///
/// cost  O(blocks): less than the walks that made them.
template <int channels>
class GroupPruning {
public:
    using Block = WaveletBlock<channels>;  ///< Block of the pruned products.

    /// For functions on faces of a size, multiplied by functions with this spectrum.
    GroupPruning(int face_size, const CoefficientSpectrum& spectrum);

    /// Removes all rows.
    void clear();

    /// The product of a row, to be written by the caller. It is used once weights are set.
    std::vector<Block>& product(std::size_t row) { return rows_[row].product; }

    /// Sets the weights of a row's squared amplitudes in the energies (EnergyWeights), by channel.
    void set_weights(std::size_t row, const std::array<float, channels>& weights);

    /// Appends one entry for each coefficient kept of the rows and channels, and one scale for each channel.
    ///
    /// error        the dropped energies are at most error^2 of all.
    /// first_group  index of the first channel's group; the others follow.
    void append(double error, std::size_t first_group, std::vector<std::uint32_t>& indices,
                std::vector<GroupEntry>& entries, std::vector<float>& scales);

    /// A row, for the vector kernels.
    struct Row {
        std::vector<Block> product;
        std::array<float, channels> weights{};
    };
    /// The data of all rows for one block.
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
    std::vector<std::uint32_t> place_;  ///< Index in shared_ plus 1, by block number; 0: absent.
    CoefficientEnergies energies_;      ///< place: channels * place in shared_ + channel.
};

}  // namespace haarfield
