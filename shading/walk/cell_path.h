#pragma once
/// Positions of cells from their paths (wide_tree.h), which are Morton numbers.

#include <cstddef>

namespace haarfield {

/// The position of a square in the grid of its level, from the left and from the top.
struct SquarePlace {
    std::size_t column = 0, row = 0;
};

/// Returns the position of a path of cells.
inline SquarePlace square_place(std::size_t path) {
    SquarePlace place;
    for (unsigned bit = 0; path >> (2 * bit) != 0; ++bit) {
        place.column |= (path >> (2 * bit) & 1) << bit;
        place.row |= (path >> (2 * bit + 1) & 1) << bit;
    }
    return place;
}

}  // namespace haarfield
