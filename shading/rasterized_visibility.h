#pragma once
/// Visibility past an occluder from any point, made where it is needed.

#include "fields/haar_transform.h"
#include "fields/visibility_rasterizer.h"
#include "fields/visibility_transform.h"
#include "shading/wide_visibility.h"

namespace haarfield {

/// What a field holds of its samples, of points that have none. Keeps its buffers: nothing is allocated once
/// they have grown.
class RasterizedVisibility {
public:
    /// face_size  is_face_size.
    explicit RasterizedVisibility(int face_size);

    /// The tree of what can be seen past the occluder; valid until the next call.
    ///
    /// view_point, horizon  as VisibilityRasterizer::open_samples has them.
    /// truncation           as VisibilityTransform has it.
    /// cost                 a rasterization and a transform: some 40 us.
    const WideCubemap<std::uint8_t>& operator()(const Occluder& occluder, const Vec3f& view_point,
                                                const Vec3f* horizon, const Truncation& truncation);

private:
    VisibilityRasterizer rasterizer_;
    VisibilityTransform transform_;
    VisibilityConverter converter_;
    CubemapTree tree_;
    std::vector<WideNode<std::uint8_t>> nodes_;
    WideCubemap<std::uint8_t> faces_;
};

}  // namespace haarfield
