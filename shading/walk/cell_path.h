#pragma once
/// Paths of cells (wide_tree.h), which are Morton numbers, as places.

#include <cstddef>

namespace haarfield {

/// Of a square among those of its level, counted from the left and from the top.
struct SquarePlace {
    std::size_t column = 0, row = 0;
};

/// The place of a path of cells.
inline SquarePlace square_place(std::size_t path) {
    SquarePlace place;
    for (unsigned bit = 0; path >> (2 * bit) != 0; ++bit) {
        place.column |= (path >> (2 * bit) & 1) << bit;
        place.row |= (path >> (2 * bit + 1) & 1) << bit;
    }
    return place;
}

}  // namespace haarfield
