#pragma once
/// The edges of an occluder at which the number of layers along rays from a view point changes.

#include <array>
#include <cstdint>
#include <vector>

#include "fields/base/aligned_buffer.h"
#include "fields/rasterizer/viewed_occluder.h"
#include "fields/wavelets/cubemap.h"

namespace haarfield {

/// The contour edges of an occluder relative to a view point.
struct VisibleContour {
    std::vector<std::uint64_t> left;  ///< One bit per triangle: set if left to the span rasterizer.

    std::size_t count = 0;                 ///< The number of contour edges.
    AlignedBuffer<std::uint32_t> numbers;  ///< The number of each edge in OccluderEdges.
    /// For each edge, the layers on its left, viewed from its first end, minus those on its right: +-1 or
    /// +-2.
    AlignedBuffer<float> weights;
    /// For turned occluders: x, y, z of the first ends relative to the view point, then of the second.
    std::array<AlignedBuffer<float>, 6> viewed_ends;

    /// Edges that may cross sub-columns of a face, on the face or between it and the pole of the sub-columns.
    struct OfFace {
        std::size_t count = 0;
        /// Relative to the view point: x, y, z of the first end, then of the second.
        std::array<AlignedBuffer<float>, 6> ends;
        AlignedBuffer<float> weights;
    };
    std::array<OfFace, cubemap_faces> of_face;

    // Buffers of find_contour: clusters above the horizon that may have contour edges, and all clusters that
    // the horizon may cut.
    std::size_t open_count = 0, cut_count = 0;
    AlignedBuffer<std::uint32_t> open, cut;
    AlignedBuffer<std::uint8_t> below;  ///< One per vertex: 1 below the horizon, 0 above.
};

/// Finds the contour of the facing triangles (viewed_occluder.h).
///
/// cost  O(edges / 128 + edges of clusters that the contour or the horizon crosses), plus vertices / 16 with
///       a horizon.
void find_contour(const Occluder& occluder, const ViewedOccluder& viewed, VisibleContour& contour);

}  // namespace haarfield
