#pragma once
/// The wavelets of a function product in the format that the walk writes.

#include "shading/walk/light_pyramid.h"

namespace haarfield {

/// Haar amplitudes (quadtree.h) of a square and its quadrants, by channel.
///
/// Slot 0 is the mean over the square. Slots 4, 8 and 12 are its wavelets along x, along y and diagonal.
/// Slots 4 Q + 1, 2 and 3 are those of quadrant Q. If the block's level is l, the square's wavelets are at
/// level 2 l of the quadtree, the quadrants' at 2 l + 1.
template <int channels>
struct WaveletBlock {
    std::uint32_t block;   ///< Its number, by BlockNumbers.
    std::uint32_t parent;  ///< Index in the list; a face's root is its own parent.
    std::uint16_t cell;    ///< Cell in the parent.
    std::uint16_t level;   ///< Level of blocks; 0 for a face's root.
    std::array<std::array<float, wide_cells>, channels> amplitude;

    WaveletBlock() {}  // NOLINT: not initialized, as the walk writes all values of thousands of blocks per
                       // vertex
};

/// Thresholds for negligible details of a product, by level of blocks, for details below one cell.
///
/// Wavelets are orthonormal: the squared coefficients below a cell add up to the mean squared deviation of
/// the product from its mean there, times the cell's fraction of the face.
struct DetailWeights {
    std::array<float, 4> weight{};      ///< Upper bound on the ratio of energy to mean square.
    std::array<float, 4> negligible{};  ///< Largest root mean square deviation that is omitted.
};

/// Converts blocks to quadtrees (quadtree.h), to be inspected, truncated, or multiplied again.
///
/// product   parents before children, with the root of every face, as function_product writes them.
/// accuracy  exact. Nodes without any wavelet are omitted.
/// cost      O(blocks).
CubemapTree cubemap_tree(std::span<const WaveletBlock<1>> product);
RgbCubemapTree cubemap_tree(std::span<const WaveletBlock<3>> product);  ///< By channel.

}  // namespace haarfield
