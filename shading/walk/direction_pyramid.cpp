#include "shading/walk/direction_pyramid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "shading/walk/cell_path.h"

namespace haarfield {

DirectionPyramid::DirectionPyramid(int face_size) {
    assert(is_face_size(face_size));
    const int levels = wide_levels(face_size);
    std::size_t count = 0;
    for (int level = 0; level < levels; ++level) {
        first_[std::size_t(level)] = count;
        count += std::size_t(1) << (4 * level);
    }
    blocks_.resize(count);

    // Averages four directions in each of the finest cells, uniformly over the face's area.
    for (int level = levels - 1; level >= 0; --level) {
        const auto cells_a_side = std::size_t(4) << (2 * level);
        double least_cosine = 1;
        for (std::size_t block = 0; block < std::size_t(1) << (4 * level); ++block)
            for (std::size_t cell = 0; cell < wide_cells; ++cell) {
                const auto [column_of_cell, row_of_cell] = square_place(block * wide_cells + cell);
                const double side = 2.0 / double(cells_a_side), u = double(column_of_cell) * side - 1,
                             v = double(row_of_cell) * side - 1;
                const int steps = level + 1 == levels ? 2 : 2 << (2 * (levels - 1 - level));
                Vec3d sum(0.0);
                for (int row = 0; row < steps; ++row)
                    for (int column = 0; column < steps; ++column)
                        sum += Vec3d(u + side * (column + 0.5) / steps, v + side * (row + 0.5) / steps, 1)
                                   .normalized();
                const Vec3d mean = sum / (steps * steps), along = mean.normalized();
                DirectionBlock& to = blocks_[first_[std::size_t(level)] + block];
                to.x[cell] = float(along.x);
                to.y[cell] = float(along.y);
                to.z[cell] = float(along.z);
                to.extent[cell] = float(std::sqrt(3 * (1 - mean.length())));
                to.inverse_extent[cell] = 1 / to.extent[cell];
                for (const double corner_u : {u, u + side})
                    for (const double corner_v : {v, v + side})
                        least_cosine =
                            std::min(least_cosine, along.dot(Vec3d(corner_u, corner_v, 1).normalized()));
            }
        sine_[std::size_t(level)] = float(std::sqrt(1 - least_cosine * least_cosine));
        cosine_[std::size_t(level)] = float(least_cosine);
    }
}

}  // namespace haarfield
