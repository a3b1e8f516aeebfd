#pragma once
/// The directions of a cubemap face by block, from which cosines are computed without tables of trees.

#include "shading/walk/wide_tree.h"

namespace haarfield {

/// The directions in the cells of a block, in the face's frame: (u, v, 1) of cubemap.h, normalised.
struct DirectionBlock {
    alignas(64) std::array<float, wide_cells> x{}, y{}, z{};  ///< Unit vector along the mean direction.
    /// Half a cell's width as an angle e [rad] that describes the spread of its directions: their mean over
    /// the face's area has length 1 - e^2 / 3.
    std::array<float, wide_cells> extent{}, inverse_extent{};
};

/// The blocks of all levels, shared by the six faces. Level l has 16^l blocks.
class DirectionPyramid {
public:
    explicit DirectionPyramid(int face_size);  ///< face_size: texels along an edge, is_face_size.

    /// Returns a block of a level.
    const DirectionBlock& block(int level, std::size_t block) const {
        return blocks_[first_[std::size_t(level)] + block];
    }
    /// Returns the sine of the largest angle between a cell's mean direction and any direction in the cell,
    /// on a level.
    float sine(int level) const { return sine_[std::size_t(level)]; }
    float cosine(int level) const { return cosine_[std::size_t(level)]; }  ///< Cosine of that angle.

private:
    std::array<std::size_t, 5> first_{};
    std::array<float, 4> sine_{}, cosine_{};
    std::vector<DirectionBlock> blocks_;
};

/// Converts a world direction to the frame of a face.
inline Vec3f in_face_frame(const Vec3f& direction, int face) {
    const Vec3f axis = cubemap_direction<Vec3f>(face, 0, 0);
    return {direction.dot(cubemap_direction<Vec3f>(face, 1, 0) - axis),
            direction.dot(cubemap_direction<Vec3f>(face, 0, 1) - axis), direction.dot(axis)};
}

/// Converts a direction from the frame of a face to the world.
inline Vec3f in_world_frame(const Vec3f& direction, int face) {
    const Vec3f axis = cubemap_direction<Vec3f>(face, 0, 0);
    return (cubemap_direction<Vec3f>(face, 1, 0) - axis) * direction.x +
           (cubemap_direction<Vec3f>(face, 0, 1) - axis) * direction.y + axis * direction.z;
}

}  // namespace haarfield
