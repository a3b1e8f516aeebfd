#pragma once
/// Visibility rasterized at a vertex, as a wide tree: used where the samples of a field are too sparse.

#include "fields/rasterizer/visibility_rasterizer.h"
#include "shading/visibility/texel_blocks.h"

namespace haarfield {

/// Rasterizes occluders from a vertex into one cubemap, lets the caller multiply it by further occluders, and
/// makes the wide tree of the cubemap. Reuses its memory: allocates nothing per vertex once it has grown.
///
/// accuracy  no truncation; texels and means are rounded to 1/255.
/// cost      about 10 to 40 us per occluder of 5,000 triangles, and 3 us for the tree. [faces of 64 texels]
class RasterizedVisibility {
public:
    explicit RasterizedVisibility(int face_size);  ///< face_size: texels along an edge, is_face_size.

    /// Rasterizes the joint visibility of occluders, as VisibilityRasterizer::open_samples; 1 if there are
    /// none. Returns it by texel, face and row, to be modified by the caller. [1/255]
    std::span<std::uint8_t> texels(std::span<const OccluderView> views);

    /// Returns the tree of the current texels; valid until the next call.
    const WideCubemap<std::uint8_t>& tree();

    /// Rasterizes occluders and returns their tree.
    const WideCubemap<std::uint8_t>& operator()(std::span<const OccluderView> views) {
        texels(views);
        return tree();
    }

    /// Returns the tree that was computed last.
    const WideCubemap<std::uint8_t>& faces() const { return faces_; }
    std::span<const WideNode<std::uint8_t>> nodes() const { return nodes_; }  ///< All nodes of that tree.

private:
    VisibilitySquares& squares(std::size_t level) {
        return level < upper_.size() ? upper_[level] : blocks_.squares;
    }
    float mean_of(std::size_t level, std::size_t path);
    void add_face(std::size_t face, std::span<const std::uint8_t> open);
    void gather_squares(std::size_t level);
    void fill_node(std::size_t index, std::size_t level, std::size_t path);

    const int face_size_;
    VisibilityRasterizer rasterizer_;
    std::vector<std::uint8_t> open_;        ///< By texel. [1/255]
    TexelBlocks blocks_;                    ///< Of the current face.
    std::vector<VisibilitySquares> upper_;  ///< Squares of the levels of nodes above the blocks.
    std::vector<std::size_t> paths_;        ///< Of the nodes of the current face.
    std::vector<WideNode<std::uint8_t>> nodes_;
    WideCubemap<std::uint8_t> faces_;
};

}  // namespace haarfield
