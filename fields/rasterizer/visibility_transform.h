#pragma once
/// From the rasterizer's counts to truncated quadtrees of visibility.

#include "fields/wavelets/haar_transform.h"

#include <cstdint>
#include <memory>

namespace haarfield {

/// Transforms one cubemap at a time; keeps its buffers.
///
/// Squares of 8 x 8 texels that are all alike, which most are, cost eight comparisons of words; only the
/// others are transformed.
class VisibilityTransform {
public:
    /// face_size  texels along an edge: a power of two from 8 to 256 (asserted).
    explicit VisibilityTransform(int face_size);
    ~VisibilityTransform();

    /// The trees of visibility = open / samples_per_texel.
    ///
    /// open        6 * face_size^2 counts, as VisibilityRasterizer::open_samples gives them.
    /// horizon     unit normal of a surface through the view point. Texels whose centres lie below it are
    ///             multiplied by zero later, and so are given what needs fewest wavelets. Null: none.
    /// truncation  `coefficients` for each face; `relative_l2_error` of the whole cubemap's occlusion
    ///             (1 - visibility), or of its visibility above the horizon if that has the smaller L2 norm:
    ///             a far object blocks little of what is open elsewhere, and in a room all light comes
    ///             through the window. Ties between wavelets go to the smaller face, the coarser level, then
    ///             the smaller index.
    /// tree        the result; its memory is reused.
    /// accuracy    exact above the horizon, but for the truncation.
    void operator()(std::span<const std::uint8_t> open, const Vec3f* horizon, const Truncation& truncation,
                    CubemapTree& tree);

private:
    struct Buffers;
    std::unique_ptr<Buffers> buffers_;
};

}  // namespace haarfield
