#pragma once
/// Texels of visibility in the order of the cells of a wide tree.

#include <span>
#include <vector>

#include "shading/walk/wide_tree.h"

namespace haarfield {

/// Squares of equal size on a face of visibility, in the order of their paths (wide_tree.h).
struct VisibilitySquares {
    /// Sums of visibility over cells; a texel of four cells counts four times. [1/255]
    std::vector<std::uint32_t> open;
    std::vector<std::uint8_t> varies;  ///< 1: visibility varies within the square; else 0.
};

/// A face divided into the squares of the deepest nodes of a wide tree. Their cells are texels, or quarters
/// of texels if log2 of the face's size is odd.
struct TexelBlocks {
    VisibilitySquares squares;
    std::vector<std::array<std::uint8_t, wide_cells>> mean;  ///< Visibility by cell. [1/255]
};

/// Fills in the blocks of a face.
///
/// open  visibility by texel and row; face_size^2 of them, face_size at least 2. [1/255]
/// cost  about 3 ns per block.
void sort_into_blocks(std::span<const std::uint8_t> open, int face_size, TexelBlocks& blocks);

}  // namespace haarfield
