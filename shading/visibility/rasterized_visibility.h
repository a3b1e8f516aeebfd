#pragma once
/// Visibility rasterized at a vertex, as a wide tree: used where the samples of a field are too sparse.

#include "fields/rasterizer/visibility_rasterizer.h"
#include "shading/visibility/texel_tree.h"

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

    const TexelTree& last() const { return tree_; }  ///< The tree that was computed last.

private:
    VisibilityRasterizer rasterizer_;
    std::vector<std::uint8_t> open_;  ///< By texel. [1/255]
    TexelTreeMaker maker_;
    TexelTree tree_;
};

}  // namespace haarfield
