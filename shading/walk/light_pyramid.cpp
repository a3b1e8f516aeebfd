#include "shading/walk/light_pyramid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace haarfield {

BlockNumbers::BlockNumbers(int face_size) : face_size_(face_size), levels_(wide_levels(face_size)) {
    assert(is_face_size(face_size));
    for (int level = 0; level < levels_; ++level)
        first_[std::size_t(level) + 1] =
            first_[std::size_t(level)] + (std::size_t(cubemap_faces) << (4 * level));
}

LightPyramid::LightPyramid(const RgbCubemapTree& light, int face_size) : numbers_(face_size) {
    blocks_.resize(numbers_.count());
    varying_.resize(numbers_.count());
    uneven_.resize(numbers_.count());
    deviations_.resize(numbers_.count());
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const RgbQuadtree& tree = light.faces[face];
        means_[face] = tree.scaling;
        constant_[face] = tree.nodes.empty();
        if (numbers_.levels() > 0) fill(tree, face, 0, 0, tree.nodes.empty() ? no_node : 0, tree.scaling);
    }
    for (const Rgb& mean : means_)
        mean_size_ += (std::abs(mean.x) + std::abs(mean.y) + std::abs(mean.z)) / float(cubemap_faces);
    const float least = 3 * mean_size_;
    for (std::size_t place = 0; place < uneven_.size(); ++place)
        for (unsigned cell = 0; cell < wide_cells; ++cell)
            if (place < cubemap_faces || deviations_[place][cell] > least)
                uneven_[place] |= static_cast<std::uint16_t>(varying_[place] & (1u << cell));
    if (numbers_.levels() > 1) add_moments();
}

/// Adds the moments of the finest cells to all levels above.
void LightPyramid::add_moments() {
    const DirectionPyramid directions(numbers_.face_size());
    const int last = numbers_.levels() - 1;
    moments_.resize(numbers_(last, 0, 0));
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        for (std::size_t block = 0; block < std::size_t(1) << (4 * last); ++block) {
            const DirectionBlock& towards = directions.block(last, block);
            const LightBlock& light = blocks_[numbers_(last, face, block)];
            for (std::size_t cell = 0; cell < wide_cells; ++cell) {
                const float spread = towards.extent[cell] * towards.extent[cell] / 3;
                const Vec3f mean =
                    in_world_frame({towards.x[cell], towards.y[cell], towards.z[cell]}, int(face)) *
                    (1 - spread);
                float share = 1;
                std::size_t path = block;
                for (int level = last - 1; level >= 0; --level, path /= wide_cells) {
                    share /= wide_cells;
                    LightMoments& above = moments_[numbers_(level, face, path / wide_cells)];
                    const float* const colour[] = {&light.red[cell], &light.green[cell], &light.blue[cell]};
                    for (std::size_t c = 0; c < 3; ++c) {
                        const Vec3f moment = mean * (*colour[c] * share);
                        above.channel[c].x[path % wide_cells] += moment.x;
                        above.channel[c].y[path % wide_cells] += moment.y;
                        above.channel[c].z[path % wide_cells] += moment.z;
                    }
                }
            }
        }
}

Vec3d LightPyramid::fill(const RgbQuadtree& tree, std::size_t face, int level, std::size_t block,
                         std::int32_t node, const Rgb& mean) {
    const std::size_t place = numbers_(level, face, block);
    Vec3d squares(0.0);
    for (unsigned cell = 0; cell < wide_cells; ++cell) {
        Rgb value = mean;
        std::int32_t below = no_node;
        if (node != no_node) {
            const RgbQuadtree::Node& square = tree.nodes[std::size_t(node)];
            value = quadrant_mean(value, square.wavelet, cell / 4);
            if (const std::int32_t child = child_of(square, cell / 4); child != no_node) {
                const RgbQuadtree::Node& quadrant = tree.nodes[std::size_t(child)];
                value = quadrant_mean(value, quadrant.wavelet, cell % 4);
                below = child_of(quadrant, cell % 4);
            }
        }
        blocks_[place].red[cell] = value.x;
        blocks_[place].green[cell] = value.y;
        blocks_[place].blue[cell] = value.z;
        const Vec3d square_of_mean = Vec3d(value) * Vec3d(value);
        Vec3d square = square_of_mean;
        if (level + 1 < numbers_.levels()) {
            if (below != no_node) varying_[place] |= static_cast<std::uint16_t>(1u << cell);
            square = fill(tree, face, level + 1, block * wide_cells + cell, below, value);
        }
        for (int channel = 0; channel < 3; ++channel)
            deviations_[place][cell] +=
                static_cast<float>(std::sqrt(std::max(0.0, square[channel] - square_of_mean[channel])));
        squares += square / double(wide_cells);
    }
    return squares;
}

}  // namespace haarfield
