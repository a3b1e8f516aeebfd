#pragma once
/// The edges of an occluder at which the number of its layers changes, as seen from a view point.

#include <array>
#include <cstdint>
#include <vector>

#include "fields/base/aligned_buffer.h"
#include "fields/rasterizer/viewed_occluder.h"
#include "fields/wavelets/cubemap.h"

namespace haarfield {

/// Which edges bound what is seen of an occluder.
struct VisibleContour {
    std::vector<std::uint64_t> left;  ///< Bit per triangle: set if it is left to the span rasterizer.

    std::size_t count = 0;                 ///< Of contour edges. Of each of them:
    AlignedBuffer<std::uint32_t> numbers;  ///< its number in OccluderEdges;
    AlignedBuffer<float> weights;          ///< the layers on its left, seen from its first end, less those on
                                           ///< its right: 1 or 2, with a sign.

    /// Those that may cross sub-columns of a face, in sight or between them and the pole they start from.
    struct OfFace {
        std::size_t count = 0;
        /// From the view point: x, y, z of the first, then of the second.
        std::array<AlignedBuffer<float>, 6> ends;
        AlignedBuffer<float> weights;
    };
    std::array<OfFace, cubemap_faces> of_face;

    // What find_contour keeps by the way: clusters above the horizon that may have contour edges, and all
    // that it may cut.
    std::size_t open_count = 0, cut_count = 0;
    AlignedBuffer<std::uint32_t> open, cut;
    AlignedBuffer<std::uint8_t> below;  ///< By vertex: 1 below the horizon, 0 above.
};

/// The contour of the triangles that count (viewed_occluder.h).
///
/// cost  O(edges / 128 + edges of clusters that the contour or the horizon crosses), and with a horizon
///       vertices / 16.
void find_contour(const Occluder& occluder, const ViewedOccluder& viewed, VisibleContour& contour);

}  // namespace haarfield
