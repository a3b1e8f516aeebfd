#pragma once
/// Visibility cubemaps by simple loops, slow and without precomputed data.

#include "fields/rasterizer/visibility_rasterizer.h"

#include <cstdint>
#include <span>
#include <vector>

namespace haarfield {

/// The rasterizer's oracle: processes one triangle and sub-row at a time, in double, without precomputation,
/// and follows sides along the other axis.
class PlainRasterizer {
public:
    explicit PlainRasterizer(int face_size);

    /// Like VisibilityRasterizer::open_samples.
    std::span<const std::uint8_t> open_samples(const Occluder& occluder, const Vec3f& view_point,
                                               const Vec3f* horizon = nullptr);

private:
    void block_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c, bool both_sides);

    int face_size_;
    int words_per_row_;
    std::vector<std::uint64_t> blocked_;  ///< One bit per sample: face, sub-row, 64 columns per word.
    std::vector<std::uint8_t> open_;
    std::vector<Vec3d> relative_;  ///< Vertices relative to the view point.
};

}  // namespace haarfield
