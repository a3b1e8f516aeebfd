#pragma once
/// The sample pattern of cubemap texels.

#include <array>
#include <cstddef>
#include <cstdint>

namespace haarfield {

/// The samples per texel: one in each of eight sub-rows, each in a different column (eight rooks).
inline constexpr int samples_per_texel = 8;

/// Returns the column offset of a sample, in texels. Texel row r has the sub-rows 8r + s, s = 0 to 7, at v =
/// (2 (8r + s) + 1) / (8 size) - 1. The sample of sub-row s in texel column c is at u = 2 (c +
/// sample_offset(s)) / size - 1.
constexpr double sample_offset(int sub_row) {
    constexpr int column[samples_per_texel] = {5, 0, 3, 6, 1, 4, 7, 2};
    return (column[sub_row % samples_per_texel] + 0.5) / samples_per_texel;
}

/// Returns the visibility of a texel with the given number of open samples.
constexpr float open_fraction(std::uint8_t open_samples) {
    return static_cast<float>(open_samples) / samples_per_texel;
}

/// The offset of a sub-column's sample within a texel row, in texel rows: the inverse of sample_offset.
/// Repeated, so that a vector can start at any of the 8 sub-columns.
struct RowOffsets {
    std::array<float, 32> rows{};
    constexpr RowOffsets() {
        for (int sub_row = 0; sub_row < samples_per_texel; ++sub_row)
            for (std::size_t repeat = 0; repeat < 32; repeat += samples_per_texel) {
                const auto sub_column = static_cast<std::size_t>(sample_offset(sub_row) * samples_per_texel);
                rows[repeat + sub_column] = (static_cast<float>(sub_row) + 0.5f) / samples_per_texel;
            }
    }
};
inline constexpr RowOffsets row_offsets;  ///< Computed at compile time.

}  // namespace haarfield
