#pragma once
/// Visibility by Embree's rays: one ray a sub-sample, any hit blocks. Slow, and independent of the
/// rasterizer.

#include "fields/occluder/occluder.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace haarfield {

/// The axis of a cubemap face, and the directions to the right of and below its centre. Written down from
/// OpenEXR's drawing, independently of cubemap.h.
struct FaceFrame {
    Vec3d axis, right, down;
};
extern const FaceFrame face_frames[6];

/// Returns the direction of sub-sample s of a texel, not normalised.
Vec3d sub_sample_direction(int face, int column, int row, int sub_sample, int face_size);

class EmbreeOracle {
public:
    /// Builds a BVH. All triangles block with both sides, so compare only at points outside of closed pieces.
    ///
    /// device_settings  settings of Embree, such as "isa=avx2".
    explicit EmbreeOracle(const Occluder& occluder, const char* device_settings = nullptr);

    bool is_open(const Vec3f& origin, const Vec3d& direction) const;

    void* scene() const { return scene_.get(); }  ///< The RTCScene.

    /// Counts the open sub-samples, in the order of VisibilityRasterizer.
    std::vector<std::uint8_t> open_samples(const Vec3f& view_point, int face_size) const;

private:
    std::shared_ptr<void> scene_;
};

}  // namespace haarfield
