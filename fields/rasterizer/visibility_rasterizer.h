#pragma once
/// Fractional visibility cubemaps, rasterized on the CPU.

#include "fields/occluder/occluder.h"
#include "fields/rasterizer/sample_pattern.h"
#include "fields/wavelets/cubemap.h"

#include <cstdint>
#include <memory>
#include <span>

namespace haarfield {

/// An occluder, and where it is seen from.
struct OccluderView {
    const Occluder* occluder;
    /// In the occluder's frame. Offset it from a surface by some 1e-4 of the occluder's radius: on the
    /// surface itself the answer is arbitrary. [m]
    Vec3f point;
    /// Unit normal of a surface through the point; triangles that lie wholly below it are left out. Null:
    /// none.
    const Vec3f* horizon = nullptr;
};

/// Rasterizes occluders; keeps its buffers, so that repeated use allocates nothing.
///
/// A direction is blocked if the ray from the view point meets a two-sided triangle of the occluder or the
/// front of a one-sided one; there is no depth. Triangles that share an edge compute the same crossing, so
/// that no crack appears; nothing is clipped, so that triangles around and behind the view point are right.
/// Which of two ways a piece goes, by its contour or triangle by triangle, changes no bit of the answer, nor
/// does the instruction set.
class VisibilityRasterizer {
public:
    /// face_size  texels along an edge, is_face_size.
    explicit VisibilityRasterizer(int face_size);
    ~VisibilityRasterizer();
    VisibilityRasterizer(VisibilityRasterizer&&) noexcept;             ///< Takes the buffers over.
    VisibilityRasterizer& operator=(VisibilityRasterizer&&) noexcept;  ///< Takes the buffers over.

    /// What can be seen past an occluder: counts of open samples, 0 to samples_per_texel, face by face and
    /// row by row, 6 * face_size^2 of them; valid until the next call. Arguments as OccluderView has them.
    ///
    /// cost  O(triangles / 64 + edges near the contour + crossed sub-columns), and with a horizon vertices
    ///       / 16; of pieces whose triangles share few edges, O(triangles + covered sub-columns).
    std::span<const std::uint8_t> open_samples(const Occluder& occluder, const Vec3f& view_point,
                                               const Vec3f* horizon = nullptr);

    /// What can be seen past all of some occluders, whose frames differ by translation and scale alone: a
    /// sample is open that is open past each.
    ///
    /// cost  that of each, and a pass over the cubemap's samples.
    std::span<const std::uint8_t> open_samples(std::span<const OccluderView> views);

private:
    struct Buffers;
    std::unique_ptr<Buffers> buffers_;
};

}  // namespace haarfield
