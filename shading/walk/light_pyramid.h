#pragma once
/// Lighting with all its levels at hand, for a walk that shares it between all vertices.

#include "shading/walk/direction_pyramid.h"

namespace haarfield {

/// The lighting over the sixteen cells of one square (wide_tree.h), by channel.
struct LightBlock {
    alignas(64) std::array<float, wide_cells> red{}, green{}, blue{};
};

/// The mean over each of the sixteen cells of one square of lighting times direction: by channel, a vector
/// in the world. Its inner product with a normal is what a surface gets that the whole cell lies above.
struct LightMoments {
    /// One channel's vectors, by cell.
    struct Channel {
        alignas(64) std::array<float, wide_cells> x{}, y{}, z{};
    };
    std::array<Channel, 3> channel;
};

/// Blocks of all levels and faces, numbered. Block b of level l on a face covers the square whose path of
/// cells from the root is b in base 16, l digits.
class BlockNumbers {
public:
    /// face_size  texels along an edge, is_face_size (asserted).
    explicit BlockNumbers(int face_size);

    int face_size() const { return face_size_; }  ///< Texels along an edge.
    int levels() const { return levels_; }        ///< wide_levels(face_size); 0 for a single texel.
    std::size_t count() const { return first_[std::size_t(levels_)]; }  ///< Blocks of all levels and faces.
    /// The number of a block.
    std::size_t operator()(int level, std::size_t face, std::size_t block) const {
        return first_[std::size_t(level)] + (face << (4 * level)) + block;
    }

private:
    int face_size_, levels_;
    std::array<std::size_t, 5> first_{};  ///< Block of each level.
};

/// A lighting tree (lighting.h) with every block of every level present: no search, at the price of memory
/// that fits a core's L2 cache for faces of 64 (320 KB).
class LightPyramid {
public:
    /// face_size  texels along an edge that the tree was made from, is_face_size. Finer nodes are averaged
    /// out.
    LightPyramid(const RgbCubemapTree& light, int face_size);

    const BlockNumbers& numbers() const { return numbers_; }  ///< How the blocks are numbered.
    /// The lighting over a block.
    const LightBlock& block(std::size_t index) const { return blocks_[index]; }
    std::uint16_t varying(std::size_t index) const { return varying_[index]; }  ///< As in WideNode.
    /// Root mean square deviation from the mean within each cell, added over the channels.
    const std::array<float, wide_cells>& deviation(std::size_t index) const { return deviations_[index]; }
    /// Above the last level.
    const LightMoments& moments(std::size_t index) const { return moments_[index]; }
    /// Cells over which a cosine cannot be held constant beside the lighting: on the first level all where it
    /// varies; below, where its deviation is three times the mean over the sphere or more. These are few, and
    /// always the same, so that what were lost on them would be lost at all points that face one way.
    std::uint16_t uneven(std::size_t index) const { return uneven_[index]; }
    const Rgb& mean(std::size_t face) const { return means_[face]; }  ///< Of a face.
    /// Mean over the faces of their means' magnitude, added over the channels.
    float mean_size() const { return mean_size_; }
    bool is_constant(std::size_t face) const { return constant_[face]; }  ///< Whether a face is constant.

private:
    /// Returns the mean over the block of the squares, by channel.
    Vec3d fill(const RgbQuadtree& tree, std::size_t face, int level, std::size_t block, std::int32_t node,
               const Rgb& mean);

    void add_moments();

    BlockNumbers numbers_;
    std::vector<LightBlock> blocks_;
    std::vector<LightMoments> moments_;
    std::vector<std::uint16_t> varying_, uneven_;
    std::vector<std::array<float, wide_cells>> deviations_;
    std::array<Rgb, cubemap_faces> means_;
    float mean_size_ = 0;
    std::array<bool, cubemap_faces> constant_{};
};

}  // namespace haarfield
