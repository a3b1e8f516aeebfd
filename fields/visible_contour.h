#pragma once
/// The edges of an occluder at which the number of its layers changes, as seen from a view point.

#include <cstdint>
#include <vector>

#include "fields/aligned_buffer.h"
#include "fields/viewed_occluder.h"

namespace haarfield {

struct VisibleContour {
    std::vector<std::uint64_t> left;  ///< Bit per triangle: set if it is left to the span rasterizer.
    std::vector<std::int8_t> facing;  ///< By triangle: 1 or -1 for one that counts, from the front or behind.

    std::size_t count = 0;               ///< Of contour edges. Of each of them:
    AlignedBuffer<std::uint32_t> edges;  ///< Its number in Occluder::contour_edges.
    AlignedBuffer<float> ends;           ///< Its ends, two of ViewedOccluder::vertices.
    AlignedBuffer<float> weights;  ///< The layers on its left, seen from the first end, less those on its
                                   ///< right: 1 or 2, with a sign.
    AlignedBuffer<std::uint32_t> outcodes;  ///< The bits that its ends have in common.
};

/// The contour of the triangles that count: all that are seen, those before one_sided from the front alone,
/// but for those that are left to the span rasterizer. Left are those of loose pieces (OccluderEdges), and
/// those that look so thin that rounding may turn them over. What lies below the horizon does not count
/// either.
///
/// cost  O(triangles / 16 + edges between clusters and within those that turn).
void find_contour(const Occluder& occluder, const ViewedOccluder& viewed, VisibleContour& contour);

}  // namespace haarfield
