#pragma once
/// Sparse vectors of neighbouring rows by coefficient, eight rows at a time: for inner products with
/// functions that have few coefficients.
///
/// source  Ng, Ramamoorthi and Hanrahan 2003, All-frequency shadows using non-linear wavelet lighting
///         approximation: only the coefficients of the light that matter in a frame are multiplied. Ours:
///         neighbours share most coefficients, so that eight of them share an index and an exponent.

#include <bit>

#include "shading/transfer/sparse_vectors.h"

namespace haarfield {

/// Rows that lie side by side.
inline constexpr std::size_t group_rows = 8;

/// One coefficient of the rows of a group: value[k] * entry_step(exponent), in units of the group's scale.
struct GroupEntry {
    std::uint8_t group;
    std::uint8_t exponent;
    std::array<std::int8_t, group_rows> value;  ///< In [-127, 127].

    bool operator==(const GroupEntry&) const = default;  ///< Equal to the last bit.
};
static_assert(sizeof(GroupEntry) == 2 + group_rows);

/// Places of the steps' upper bits in a float: three of them of its mantissa, so that a step is at most an
/// eighth larger than it need be.
inline constexpr unsigned step_shift = 20;
/// The upper bits of the smallest step.
inline constexpr unsigned first_step = (0x3f800000u >> step_shift) - 255;

/// From 2^-32 to 1, in eight steps an octave.
inline float entry_step(std::uint8_t exponent) {
    return std::bit_cast<float>((first_step + exponent) << step_shift);
}

/// Sparse vectors of a block of groups: for each coefficient, the groups that have it.
///
/// Layout  arrays, no pointers: 10 bytes for eight values, and 4 an index, used or not.
struct GroupedColumns {
    static constexpr std::size_t most_groups = 256;

    std::vector<std::uint32_t> first{0};  ///< By index, one more at the end: where its entries start.
    std::vector<GroupEntry> entry;        ///< By index; groups ascend.
    std::vector<float> scale;             ///< By group: what a value of 1 times a step of 1 stands for. [f]

    GroupedColumns() = default;
    /// From entries by group, most_groups at most (asserted), and their indices.
    ///
    /// cost  one pass to count and one to write.
    GroupedColumns(int face_size, std::span<const std::uint32_t> indices, std::span<const GroupEntry> entries,
                   std::vector<float> scales);

    std::size_t bytes() const;  ///< Memory. [bytes]
};

/// Those coefficients of an RGB function that are kept, by ascending index.
struct FewCoefficients {
    std::vector<std::uint32_t> index;
    std::vector<std::array<float, 4>> value;  ///< Red, green, blue, 0. [f]
};

/// Leaves out what matters least in inner products with functions of a spectrum: the energies left out
/// (EnergyWeights) add up to at most  error^2  of all.
FewCoefficients largest_coefficients(const DenseCoefficients& f, const CoefficientSpectrum& spectrum,
                                     float error);

/// Three channels of the rows of a group, side by side.
using GroupSums = std::array<std::array<float, group_rows>, 3>;

/// sums[group] += <rows of the group, f> / scale[group], per channel.
///
/// accuracy  sums in float, in the order of f's coefficients. The same bits on every processor.
/// cost      three multiplications and additions of eight lanes for each of the groups' coefficients that f
///           has: what f lacks is not read.
void add_inner_products(const GroupedColumns& vectors, const FewCoefficients& f, std::span<GroupSums> sums);

}  // namespace haarfield
