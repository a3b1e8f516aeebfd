#pragma once
/// What a vertex itself sees past occluders, as wide trees: for where a field's samples lie too far apart.

#include "fields/visibility_rasterizer.h"
#include "shading/wide_tree.h"

namespace haarfield {

/// Rasterizes occluders from a vertex, all of them into one cubemap, and makes the cubemap's wide tree. Keeps
/// its memory: nothing is allocated per vertex once it has grown.
///
/// accuracy  every texel is there; means are rounded to 1/255.
/// cost      some 10 to 40 us an occluder of 5,000 triangles, and 4 us for the tree. [faces of 64 texels]
class SeenVisibility {
public:
    explicit SeenVisibility(int face_size) : face_size_(face_size), rasterizer_(face_size) {}

    /// The visibility past all of some occluders, as VisibilityRasterizer::open_samples has it; valid until
    /// the next call.
    const WideCubemap<std::uint8_t>& operator()(std::span<const OccluderView> views);

private:
    /// A node's square.
    struct Square {
        std::uint32_t left, top;  ///< [texels]
        float mean;               ///< Of the visibility.
    };

    void add_face(const std::uint8_t* texels);
    void fill_node(std::size_t index, std::uint32_t side, const std::uint8_t* texels);

    const int face_size_;
    VisibilityRasterizer rasterizer_;
    WideCubemap<std::uint8_t> faces_;
    std::vector<WideNode<std::uint8_t>> nodes_;
    std::vector<Square> squares_;  ///< By node.
};

}  // namespace haarfield
