#pragma once
/// Texels of visibility in the order of a wide tree's cells.

#include <span>
#include <vector>

#include "shading/walk/wide_tree.h"

namespace haarfield {

/// Squares of one size on a face of visibility, in the order of their paths (wide_tree.h).
struct VisibilitySquares {
    std::vector<std::uint32_t>
        open;  ///< Sums of visibility; a texel of four cells counts four times. [1/255]
    std::vector<std::uint8_t> varies;  ///< 1: the visibility differs within the square; else 0.
};

/// A face in the squares of a wide tree's deepest nodes. Their cells are texels, or quarters of texels if the
/// face's edge is an odd power of two.
struct TexelBlocks {
    VisibilitySquares squares;
    std::vector<std::array<std::uint8_t, wide_cells>> mean;  ///< Visibility of the cells. [1/255]
};

/// Fills in the blocks of a face.
///
/// open  visibility by texel, row by row; face_size^2 of them, face_size at least 2. [1/255]
/// cost  some 3 ns a block.
void sort_into_blocks(std::span<const std::uint8_t> open, int face_size, TexelBlocks& blocks);

}  // namespace haarfield
