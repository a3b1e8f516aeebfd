#pragma once
/// Lighting stored for every block of every level, for a walk that shares it between all vertices.

#include "shading/walk/direction_pyramid.h"

namespace haarfield {

/// Lighting over the sixteen cells of a square (wide_tree.h), by channel.
struct LightBlock {
    alignas(64) std::array<float, wide_cells> red{}, green{}, blue{};
};

/// Mean of lighting times direction over each of the sixteen cells of a square: a vector in the world for
/// each channel. Its inner product with a normal is the irradiance of a surface if the whole cell lies above
/// the horizon.
struct LightMoments {
    /// Vectors of one channel, by cell.
    struct Channel {
        alignas(64) std::array<float, wide_cells> x{}, y{}, z{};
    };
    std::array<Channel, 3> channel;
};

/// Numbers the blocks of all levels and faces. Block b of level l on a face covers the square whose path of
/// cells from the root is b in base 16, with l digits.
class BlockNumbers {
public:
    /// face_size  texels along an edge, is_face_size (asserted).
    explicit BlockNumbers(int face_size);

    int face_size() const { return face_size_; }  ///< Texels along an edge.
    int levels() const { return levels_; }        ///< wide_levels(face_size); 0 for a single texel.
    std::size_t count() const { return first_[std::size_t(levels_)]; }  ///< Blocks of all levels and faces.
    /// Returns the number of a block.
    std::size_t operator()(int level, std::size_t face, std::size_t block) const {
        return first_[std::size_t(level)] + (face << (4 * level)) + block;
    }

private:
    int face_size_, levels_;
    std::array<std::size_t, 5> first_{};  ///< First block of each level.
};

/// A lighting tree (lighting.h) with every block of every level. Lookups need no search. The memory fits a
/// core's L2 cache for faces of 64 (320 KB).
class LightPyramid {
public:
    /// face_size  texels along an edge, is_face_size. Finer nodes of the tree are averaged.
    LightPyramid(const RgbCubemapTree& light, int face_size);

    const BlockNumbers& numbers() const { return numbers_; }  ///< The numbering of the blocks.
    /// Returns the lighting over a block.
    const LightBlock& block(std::size_t index) const { return blocks_[index]; }
    std::uint16_t varying(std::size_t index) const { return varying_[index]; }  ///< As in WideNode.
    /// Returns the root mean square deviation from the mean within each cell, summed over the channels.
    const std::array<float, wide_cells>& deviation(std::size_t index) const { return deviations_[index]; }
    /// Returns the moments of a block above the last level.
    const LightMoments& moments(std::size_t index) const { return moments_[index]; }
    /// Returns cells over which the cosine must not be replaced by its mean. On the first level these are all
    /// cells where the lighting varies. Below, they are the cells where its deviation is at least three times
    /// the mean over the sphere. An error here is the same for all points with one normal, so it does not
    /// average out.
    std::uint16_t uneven(std::size_t index) const { return uneven_[index]; }
    const Rgb& mean(std::size_t face) const { return means_[face]; }  ///< Mean over a face.
    /// Returns the mean over the faces of the magnitudes of their means, summed over the channels.
    float mean_size() const { return mean_size_; }
    bool is_constant(std::size_t face) const { return constant_[face]; }  ///< True if it has no wavelets.

private:
    /// Fills a block and those below. Returns the mean over the block of the squared lighting, by channel.
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
