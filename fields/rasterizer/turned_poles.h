#pragma once
/// Layers of an occluder along the axes of a cubemap whose frame is turned.

#include <array>
#include <vector>

#include "fields/base/aligned_buffer.h"
#include "fields/rasterizer/viewed_occluder.h"
#include "fields/rasterizer/visible_contour.h"

namespace haarfield {

/// Buffers of find_turned_poles.
struct TurnedPoles {
    /// By axis: the layers of facing triangles in the negative direction, then in the positive one.
    std::array<std::array<int, 2>, 3> layers{};

    AlignedBuffer<std::uint32_t> clusters;  ///< Clusters of edges near an axis.
    std::vector<std::uint32_t> triangles;   ///< Triangles that an axis may meet.
};

/// Counts the layers along the axes of a turned cubemap, by the same exact predicate as layers_along_axis.
/// From outside the occluder's sphere, the contour alone determines them, as no axis meets the sphere in both
/// directions.
///
/// cost  O(contour edges); from inside the sphere O(edges / 128 + edges of clusters near an axis).
void find_turned_poles(const Occluder& occluder, const ViewedOccluder& viewed, const VisibleContour& contour,
                       TurnedPoles& poles);

}  // namespace haarfield
