#pragma once
/// Fractional visibility cubemaps, rasterized on the CPU.

#include "fields/occluder.h"

#include <cstdint>
#include <span>
#include <vector>

namespace haarfield {

/// Samples in a texel: one in each of eight sub-rows, in different columns (eight rooks).
inline constexpr int samples_per_texel = 8;

/// Rasterizes one occluder at a time; keeps its buffers, so that repeated use allocates nothing.
///
/// A direction is blocked if any triangle of the occluder meets the ray from the view point; there is no
/// depth. Triangles that share an edge compute the same crossing, so that no crack appears; nothing is
/// clipped, so that triangles around and behind the view point are right.
class VisibilityRasterizer {
public:
    /// face_size  texels along an edge, is_face_size.
    explicit VisibilityRasterizer(int face_size);

    /// What can be seen past the occluder: counts of open samples, 0 to samples_per_texel, face by face
    /// and row by row, 6 * face_size^2 of them; valid until the next call.
    ///
    /// view_point  where from, in the occluder's frame. Offset it from a surface by some 1e-4 of the
    ///             occluder's radius: on the surface itself the answer is arbitrary.
    /// horizon     unit normal of a surface through the view point; triangles that lie wholly below it
    ///             are left out. Null: none.
    /// cost        O(triangles + covered sub-rows).
    std::span<const std::uint8_t> open_samples(const Occluder& occluder, const Vec3f& view_point,
                                               const Vec3f* horizon = nullptr);

private:
    int face_size_;
    int words_per_row_;
    std::vector<std::uint64_t> blocked_;  ///< Bit per sample: face, sub-row, 64 columns a word.
    std::vector<std::uint8_t> open_;
    std::vector<Vec3f> relative_;
};

}  // namespace haarfield
