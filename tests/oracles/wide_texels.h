#pragma once
/// Conversion of wide trees to texels.

#include <algorithm>

#include "shading/walk/wide_tree.h"

namespace haarfield {

/// Draws the content of a node, or the mean if there is none, into a square of a face's texels.
inline void draw(const WideNode<std::uint8_t>* node, double mean, int x, int y, int side, int size,
                 std::vector<double>& texels) {
    if (!node || side == 1) {
        for (int row = y; row < y + side; ++row)
            for (int column = x; column < x + side; ++column) texels[std::size_t(row * size + column)] = mean;
        return;
    }
    for (unsigned cell = 0; cell < wide_cells; ++cell) {
        const int cx = int(cell / 4 % 2) * 2 + int(cell % 2), cy = int(cell / 8) * 2 + int(cell % 4 / 2);
        draw(node->varying >> cell & 1u ? child_of(node, cell) : nullptr, node->mean[cell] / 255.0,
             x + cx * side / 4, y + cy * side / 4, std::max(side / 4, 1), size, texels);
    }
}

/// Returns the visibility of each texel, in row-major order.
inline std::vector<double> texels_of(const WideFace<std::uint8_t>& face, int size) {
    std::vector<double> texels(std::size_t(size) * std::size_t(size));
    draw(face.root, face.mean, 0, 0, size, size, texels);
    return texels;
}

}  // namespace haarfield
