#pragma once
/// Visibility cubemaps by a plain loop, slow and without precomputed data.

#include "fields/rasterizer/visibility_rasterizer.h"

#include <cstdint>
#include <span>
#include <vector>

namespace haarfield {

/// The rasterizer's oracle: one triangle and sub-row after the other, in double, with nothing precomputed and
/// sides followed along the other axis.
class PlainRasterizer {
public:
    explicit PlainRasterizer(int face_size);

    /// As VisibilityRasterizer's.
    std::span<const std::uint8_t> open_samples(const Occluder& occluder, const Vec3f& view_point,
                                               const Vec3f* horizon = nullptr);

private:
    void block_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c, bool both_sides);

    int face_size_;
    int words_per_row_;
    std::vector<std::uint64_t> blocked_;  ///< Bit per sample: face, sub-row, 64 columns a word.
    std::vector<std::uint8_t> open_;
    std::vector<Vec3d> relative_;  ///< Vertices, seen from the view point.
};

}  // namespace haarfield
