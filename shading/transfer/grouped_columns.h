#pragma once
/// Sparse vectors of neighbouring rows by coefficient, eight rows at a time: for inner products with
/// functions that have few coefficients.
///
/// source  Ng, Ramamoorthi and Hanrahan 2003, All-frequency shadows using non-linear wavelet lighting
///         approximation: only the important coefficients of a frame's light are multiplied. Difference:
///         neighbours share most coefficients, so eight rows share an index and an exponent.

#include <bit>

#include "shading/transfer/sparse_vectors.h"

namespace haarfield {

/// Number of rows in a group.
inline constexpr std::size_t group_rows = 8;

/// One coefficient of a group's rows: value[k] * entry_step(exponent), in units of the group's scale.
struct GroupEntry {
    std::uint8_t group;
    std::uint8_t exponent;
    std::array<std::int8_t, group_rows> value;  ///< In [-127, 127].

    bool operator==(const GroupEntry&) const = default;  ///< Bitwise equality.
};
static_assert(sizeof(GroupEntry) == 2 + group_rows);

/// Position of a step's upper bits in a float. They include three bits of the mantissa, so that a step
/// exceeds the necessary size by at most an eighth.
inline constexpr unsigned step_shift = 20;
/// Upper bits of the smallest step.
inline constexpr unsigned first_step = (0x3f800000u >> step_shift) - 255;

/// Returns a step, from 2^-32 to 1 in eight steps per octave.
inline float entry_step(std::uint8_t exponent) {
    return std::bit_cast<float>((first_step + exponent) << step_shift);
}

/// Sparse vectors of a block of groups, by coefficient.
///
/// Layout  arrays without pointers: 10 bytes for eight values, and 4 bytes for each index, used or not.
struct GroupedColumns {
    static constexpr std::size_t most_groups = 256;

    std::vector<std::uint32_t> first{0};  ///< Start of the entries by index, followed by the total.
    std::vector<GroupEntry> entry;        ///< By index; groups in ascending order.
    std::vector<float> scale;             ///< By group: the factor of value times step. [f]

    GroupedColumns() = default;
    /// Builds columns from the entries of at most most_groups groups (asserted) and their indices.
    ///
    /// cost  one pass to count and one to write.
    GroupedColumns(int face_size, std::span<const std::uint32_t> indices, std::span<const GroupEntry> entries,
                   std::vector<float> scales);

    std::size_t bytes() const;  ///< Memory. [bytes]
};

/// The selected coefficients of an RGB function, by ascending index.
struct SelectedCoefficients {
    std::vector<std::uint32_t> index;
    std::vector<std::array<float, 4>> value;  ///< Red, green, blue, 0. [f]
};

/// Drops the least important coefficients for inner products with functions of a spectrum. The dropped
/// energies (EnergyWeights) are at most  error^2  of all.
SelectedCoefficients largest_coefficients(const DenseCoefficients& f, const CoefficientSpectrum& spectrum,
                                          float error);

/// Three channels of a group's rows.
using GroupSums = std::array<std::array<float, group_rows>, 3>;

/// Computes sums[group] += <rows of the group, f> / scale[group], per channel.
///
/// accuracy  float sums in the order of f's coefficients. Bit-identical on all processors.
/// cost      three multiplications and additions of eight lanes for each of the groups' coefficients that f
///           has; others are not read.
void add_inner_products(const GroupedColumns& vectors, const SelectedCoefficients& f,
                        std::span<GroupSums> sums);

}  // namespace haarfield
