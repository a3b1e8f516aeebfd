#pragma once
/// The directions of a cubemap face by block, so that cosines need no table of trees.

#include "shading/walk/wide_tree.h"

namespace haarfield {

/// The directions in the cells of one block, in the face's own frame: (u, v, 1) of cubemap.h, normalised.
struct DirectionBlock {
    alignas(64) std::array<float, wide_cells> x{}, y{}, z{};  ///< Unit vector along the mean direction.
    /// Half a cell's width, as the angle e [rad] that gives the directions their spread: the mean direction
    /// over the face's area has length 1 - e^2 / 3.
    std::array<float, wide_cells> extent{}, inverse_extent{};
};

/// All six faces share one pyramid. Level l has the 16^l blocks of one face.
class DirectionPyramid {
public:
    explicit DirectionPyramid(int face_size);  ///< face_size: texels along an edge, is_face_size.

    /// A block of a level.
    const DirectionBlock& block(int level, std::size_t block) const {
        return blocks_[first_[std::size_t(level)] + block];
    }
    /// Of the largest angle between a cell's mean direction and any direction in it, on a level.
    float sine(int level) const { return sine_[std::size_t(level)]; }
    float cosine(int level) const { return cosine_[std::size_t(level)]; }  ///< Its cosine.

private:
    std::array<std::size_t, 5> first_{};
    std::array<float, 4> sine_{}, cosine_{};
    std::vector<DirectionBlock> blocks_;
};

/// A world direction in the frame of a face.
inline Vec3f in_face_frame(const Vec3f& direction, int face) {
    const Vec3f axis = cubemap_direction<Vec3f>(face, 0, 0);
    return {direction.dot(cubemap_direction<Vec3f>(face, 1, 0) - axis),
            direction.dot(cubemap_direction<Vec3f>(face, 0, 1) - axis), direction.dot(axis)};
}

/// A direction in the frame of a face, in the world.
inline Vec3f in_world_frame(const Vec3f& direction, int face) {
    const Vec3f axis = cubemap_direction<Vec3f>(face, 0, 0);
    return (cubemap_direction<Vec3f>(face, 1, 0) - axis) * direction.x +
           (cubemap_direction<Vec3f>(face, 0, 1) - axis) * direction.y + axis * direction.z;
}

}  // namespace haarfield
