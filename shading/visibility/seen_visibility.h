#pragma once
/// What a vertex itself sees past occluders, as wide trees: for where a field's samples lie too far apart.

#include "fields/rasterizer/visibility_rasterizer.h"
#include "shading/visibility/texel_blocks.h"

namespace haarfield {

/// Rasterizes occluders from a vertex, all of them into one cubemap, lets others lessen it, and makes the
/// cubemap's wide tree. Keeps its memory: nothing is allocated per vertex once it has grown.
///
/// accuracy  every texel is there; texels and means are rounded to 1/255.
/// cost      some 10 to 40 us an occluder of 5,000 triangles, and 3 us for the tree. [faces of 64 texels]
class SeenVisibility {
public:
    explicit SeenVisibility(int face_size);  ///< face_size: texels along an edge, is_face_size.

    /// The visibility past all of some occluders, as VisibilityRasterizer::open_samples has it; 1 if there
    /// are none. By texel, face by face and row by row; to be lessened by what hides more. [1/255]
    std::span<std::uint8_t> texels(std::span<const OccluderView> views);

    /// The tree of these texels as they are now; valid until the next call.
    const WideCubemap<std::uint8_t>& tree();

    /// The same of occluders alone.
    const WideCubemap<std::uint8_t>& operator()(std::span<const OccluderView> views) {
        texels(views);
        return tree();
    }

    /// What was seen last, and all of its nodes.
    const WideCubemap<std::uint8_t>& faces() const { return faces_; }
    std::span<const WideNode<std::uint8_t>> nodes() const { return nodes_; }  ///< Of all of its trees.

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
    TexelBlocks blocks_;                    ///< Of the face at hand,
    std::vector<VisibilitySquares> upper_;  ///< and the squares of the levels of nodes above them.
    std::vector<std::size_t> paths_;        ///< Of the face's nodes.
    std::vector<WideNode<std::uint8_t>> nodes_;
    WideCubemap<std::uint8_t> faces_;
};

}  // namespace haarfield
