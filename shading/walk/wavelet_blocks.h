#pragma once
/// The wavelets of a function product, as the walk that finds them writes them down.

#include "shading/walk/light_pyramid.h"

namespace haarfield {

/// Haar amplitudes (quadtree.h) of one square and its quadrants, by channel.
///
/// Slot 0 is the mean over the square, slots 4, 8 and 12 its wavelets along x, along y and diagonal; slots
/// 4 Q + 1, 2 and 3 are those of quadrant Q. With l the block's level the square's wavelets are at level 2 l
/// of the quadtree, the quadrants' at 2 l + 1.
template <int channels>
struct WaveletBlock {
    std::uint32_t block;   ///< Its number: BlockNumbers.
    std::uint32_t parent;  ///< Place in the list; of a face's root: its own.
    std::uint16_t cell;    ///< Of the parent.
    std::uint16_t level;   ///< Of blocks: 0 for a face's root.
    std::array<std::array<float, wide_cells>, channels> amplitude;

    WaveletBlock() {}  // NOLINT: of thousands a vertex, whose values are written next, none is cleared first
};

/// Which details of a product do not matter: by level of blocks, what lies below one of its cells.
///
/// Wavelets are orthonormal, so that the squares of the coefficients below a cell add up to the mean square
/// of what the product deviates by from its mean there, times the cell's share of the face.
struct DetailWeights {
    std::array<float, 4> weight{};      ///< From a mean square to an energy: at least.
    std::array<float, 4> negligible{};  ///< Root mean square deviations up to here are left out.
};

/// The function that blocks hold the wavelets of, as quadtrees (quadtree.h): to be looked at, truncated, or
/// multiplied again.
///
/// product   parents before children, with the root of every face, as function_product writes them.
/// accuracy  exact. Nodes without any wavelet are left out.
/// cost      O(blocks).
CubemapTree cubemap_tree(std::span<const WaveletBlock<1>> product);
RgbCubemapTree cubemap_tree(std::span<const WaveletBlock<3>> product);  ///< The same of a colour.

}  // namespace haarfield
