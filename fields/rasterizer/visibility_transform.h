#pragma once
/// Transformation of the rasterizer's counts to truncated quadtrees of visibility.

#include "fields/wavelets/haar_transform.h"

#include <cstdint>
#include <memory>

namespace haarfield {

/// Transforms one cubemap at a time. Keeps its buffers.
///
/// Most blocks of 8 x 8 texels are uniform and cost eight comparisons of words. Only the others are
/// transformed.
class VisibilityTransform {
public:
    /// face_size  texels along an edge: a power of two from 8 to 256 (asserted).
    explicit VisibilityTransform(int face_size);
    ~VisibilityTransform();

    /// Computes the trees of visibility = open / samples_per_texel.
    ///
    /// open        6 * face_size^2 counts, in the order of VisibilityRasterizer::open_samples.
    /// horizon     unit normal of a surface through the view point. Texels with centres below the surface get
    ///             values that need few wavelets, because they are later multiplied by zero. Null: no
    ///             surface.
    /// truncation  `coefficients` applies to each face. `relative_l2_error` is relative to the L2 norm of the
    ///             cubemap's occlusion (1 - visibility), or of its visibility above the horizon if that is
    ///             smaller: a far object blocks few directions, and in a room all light comes through the
    ///             window. Ties between wavelets go to the smaller face, the coarser level, then the smaller
    ///             index.
    /// tree        the result; its memory is reused.
    /// accuracy    exact above the horizon, except for the truncation.
    void operator()(std::span<const std::uint8_t> open, const Vec3f* horizon, const Truncation& truncation,
                    CubemapTree& tree);

private:
    struct Buffers;
    std::unique_ptr<Buffers> buffers_;
};

}  // namespace haarfield
