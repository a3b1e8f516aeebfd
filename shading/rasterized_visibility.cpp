#include "shading/rasterized_visibility.h"

namespace haarfield {

RasterizedVisibility::RasterizedVisibility(int face_size) : rasterizer_(face_size), transform_(face_size) {}

const WideCubemap<std::uint8_t>& RasterizedVisibility::operator()(const Occluder& occluder,
                                                                  const Vec3f& view_point,
                                                                  const Vec3f* horizon,
                                                                  const Truncation& truncation) {
    transform_(rasterizer_.open_samples(occluder, view_point, horizon), horizon, truncation, tree_);
    nodes_.clear();
    std::array<std::size_t, cubemap_faces> root;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        root[face] = nodes_.size();
        faces_[face].mean = converter_.append(tree_.faces[face], nodes_);
    }
    // Only now do the nodes stay where they are.
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const std::size_t end = face + 1 < cubemap_faces ? root[face + 1] : nodes_.size();
        faces_[face].root = end > root[face] ? &nodes_[root[face]] : nullptr;
    }
    return faces_;
}

}  // namespace haarfield
