#pragma once
/// An occluder as it is seen from a view point: what both paths of the visibility rasterizer start from.

#include <cstdint>

#include "fields/aligned_buffer.h"
#include "fields/occluder.h"

namespace haarfield {

struct ViewedOccluder {
    Vec3f view_point;
    bool horizon = false;           ///< Whether there is one.
    AlignedBuffer<float> vertices;  ///< x, y, z from the view point, never 0, and an outcode (view_frame.h).

    // A bit per triangle. Those without area and those seen exactly edge-on are in none.
    AlignedBuffer<std::uint64_t> front, back;  ///< Seen from the front, or from behind.
    AlignedBuffer<std::uint64_t> thin;  ///< Those of them that look so thin that rounding may turn them over.
};

/// horizon  as VisibilityRasterizer's: sets a bit of the outcodes.
/// cost     O(vertices + triangles), less than a nanosecond each.
void look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon, ViewedOccluder& viewed);

}  // namespace haarfield
