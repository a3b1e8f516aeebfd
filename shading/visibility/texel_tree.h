#pragma once
/// Wide trees of visibility that is known by texel.

#include "shading/visibility/texel_blocks.h"

namespace haarfield {

/// The wide tree of a cubemap of visibility.
struct TexelTree {
    WideCubemap<std::uint8_t> faces;            ///< Refers to `nodes`.
    std::vector<WideNode<std::uint8_t>> nodes;  ///< Of all faces.

    TexelTree() = default;
    TexelTree(TexelTree&&) = default;             ///< Moves the nodes; a copy would refer to the original's.
    TexelTree& operator=(TexelTree&&) = default;  ///< As the constructor.
};

/// Makes wide trees from texels. Reuses its memory.
///
/// accuracy  no truncation; means are rounded to 1/255.
/// cost      3 us per tree. [faces of 64 texels]
class TexelTreeMaker {
public:
    explicit TexelTreeMaker(int face_size);  ///< face_size: texels along an edge, is_face_size.

    /// Makes the tree of a cubemap.
    ///
    /// open  visibility by texel, face and row. [1/255]
    void make(std::span<const std::uint8_t> open, TexelTree& tree);

private:
    VisibilitySquares& squares(std::size_t level) {
        return level < upper_.size() ? upper_[level] : blocks_.squares;
    }
    float mean_of(std::size_t level, std::size_t path);
    void add_face(std::size_t face, std::span<const std::uint8_t> open, TexelTree& tree);
    void gather_squares(std::size_t level);
    void fill_node(std::size_t index, std::size_t level, std::size_t path, TexelTree& tree);

    const int face_size_;
    TexelBlocks blocks_;                    ///< Of the current face.
    std::vector<VisibilitySquares> upper_;  ///< Squares of the levels of nodes above the blocks.
    std::vector<std::size_t> paths_;        ///< Of the nodes of the current face.
};

}  // namespace haarfield
