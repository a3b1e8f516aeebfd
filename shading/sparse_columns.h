#pragma once
/// Sparse vectors by coefficient instead of by row: for inner products with functions that have few of them.
///
/// source  Ng, Ramamoorthi and Hanrahan 2003, All-frequency shadows using non-linear wavelet lighting
///         approximation: only the coefficients of the light that matter in a frame are multiplied.

#include "shading/sparse_vectors.h"

namespace haarfield {

/// Sparse vectors of one channel, transposed: for each coefficient, the rows that have it.
///
/// Layout  arrays, no pointers: 2 bytes a row and 2 a value, and 4 an index, used or not.
struct SparseColumns {
    std::vector<std::uint32_t> first{0};  ///< By index, one more at the end: where its rows start.
    std::vector<std::uint16_t> row;       ///< Ascending for each index.
    std::vector<std::uint16_t> value;     ///< IEEE half floats; some zeros at the end. [f / scale]
    std::vector<float> scale;             ///< By row, as in SparseVectors.

    SparseColumns() = default;
    /// At most 65,536 rows of one channel (asserted). cost: one pass to count and one to write.
    explicit SparseColumns(const SparseVectors& vectors);

    std::size_t bytes() const;

    /// Calls use(index, row, value / scale) for each coefficient.
    template <class Use>
    void for_each(const Use& use) const {
        for (std::uint32_t index = 0; index + 1 < first.size(); ++index)
            for (std::uint32_t i = first[index]; i < first[index + 1]; ++i)
                use(index, row[i], half_value(value[i]));
    }
};

/// Those coefficients of an RGB function that are kept, by ascending index.
struct FewCoefficients {
    std::vector<std::uint32_t> index;
    std::vector<std::array<float, 4>> value;  ///< Red, green, blue, 0. [f]
};

/// Leaves out what matters least in inner products with functions of a spectrum: the energies left out,
/// as ProductPruning has them, add up to at most  error^2  of all.
FewCoefficients largest_coefficients(const DenseCoefficients& f, const CoefficientSpectrum& spectrum,
                                     float error);

/// sums[row] += <vectors[row], f> per channel, and nothing to the fourth number.
///
/// accuracy  sums in float, in the order of f's coefficients. The same bits on every processor.
/// cost      a multiplication and an addition of four lanes for each of the rows' coefficients that f has:
///           what f lacks is not read.
void add_inner_products(const SparseColumns& vectors, const FewCoefficients& f,
                        std::span<std::array<float, 4>> sums);

}  // namespace haarfield
