#pragma once
/// Fractional visibility cubemaps, rasterized on the CPU.

#include "fields/occluder/occluder.h"
#include "fields/rasterizer/sample_pattern.h"
#include "fields/wavelets/cubemap.h"

#include <cstdint>
#include <memory>
#include <span>

namespace haarfield {

/// An occluder and the point from which to sample visibility.
struct OccluderView {
    const Occluder* occluder;
    /// The view point in the occluder's frame. Offset it from a surface by about 1e-4 of the occluder's
    /// radius: exactly on the surface, the result is arbitrary. [m]
    Vec3f point;
    /// Unit normal of a surface through the point. Triangles entirely below the surface are skipped. Null: no
    /// surface.
    const Vec3f* horizon = nullptr;
    /// Rotates from the occluder's frame to the cubemap's, which is also that of the horizon. Null: both have
    /// the same axes.
    const Rotation* turn = nullptr;
};

/// Rasterizes occluders. Keeps its buffers, so that repeated use allocates nothing.
///
/// A direction is blocked if the ray from the view point hits a two-sided triangle of the occluder or the
/// front of a one-sided one. There is no depth. Triangles that share an edge compute the same crossing, so
/// that there are no cracks. Nothing is clipped, so that triangles around and behind the view point are
/// handled correctly. Triangles are drawn by their contour or one by one. Results are bit-identical for both
/// paths and for all instruction sets.
class VisibilityRasterizer {
public:
    /// face_size  texels along an edge, is_face_size.
    explicit VisibilityRasterizer(int face_size);
    ~VisibilityRasterizer();
    VisibilityRasterizer(VisibilityRasterizer&&) noexcept;             ///< Takes ownership of the buffers.
    VisibilityRasterizer& operator=(VisibilityRasterizer&&) noexcept;  ///< Takes ownership of the buffers.

    /// Returns the visibility around an occluder: counts of open samples, 0 to samples_per_texel, face by
    /// face in row-major order, 6 * face_size^2 in all. The result is valid until the next call. The
    /// arguments are those of OccluderView.
    ///
    /// cost  O(triangles / 64 + edges near the contour + crossed sub-columns), plus vertices / 16 with a
    ///       horizon. For submeshes whose triangles share few edges, O(triangles + covered sub-columns).
    std::span<const std::uint8_t> open_samples(const Occluder& occluder, const Vec3f& view_point,
                                               const Vec3f* horizon = nullptr);

    /// Returns the visibility around an occluder in any frame.
    std::span<const std::uint8_t> open_samples(const OccluderView& view) {
        return open_samples(std::span(&view, 1));
    }

    /// Returns the visibility around several occluders: a sample is open if none of them blocks it.
    ///
    /// cost  the sum of their costs, and one pass over the cubemap's samples for each.
    std::span<const std::uint8_t> open_samples(std::span<const OccluderView> views);

private:
    struct Buffers;
    std::unique_ptr<Buffers> buffers_;
};

}  // namespace haarfield
