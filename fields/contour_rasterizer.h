#pragma once
/// The path of the visibility rasterizer for closed surfaces: only the edges between triangles seen from the
/// front and others matter.

#include <span>
#include <vector>

#include "fields/span_rasterizer.h"

namespace haarfield {

struct ContourScratch {
    std::vector<std::uint64_t> front;  ///< Bit per triangle: seen from the front, and not below the horizon.
    std::vector<std::uint32_t> contour;    ///< Indices of contour edges.
    AlignedBuffer<float> edges;            ///< Contour edges: both ends as in ViewedOccluder::vertices.
    AlignedBuffer<float> queue, lines;     ///< Those of them that matter to a face, and their lines on it.
    AlignedBuffer<std::uint8_t> counters;  ///< Changes of the number of layers: texel row, sub-column.
    AlignedBuffer<std::uint8_t> blocked;   ///< Bit per sample: texel row, sub-column.
    std::vector<std::int32_t> entering;    ///< Changes of the number of entering edges, by sub-column.
};

/// Open samples of each texel past the one-sided triangles of an occluder, as block_spans and
/// count_open_samples have it. False, and nothing to be used in `open`, where that is not certain: the
/// surface is not closed, an axis through the view point meets an edge, or there may be more than 255 layers.
///
/// cost  O(triangles / 16 + contour edges + crossed sub-columns).
bool open_samples_by_contour(const Occluder& occluder, const ViewedOccluder& viewed, const Vec3f& view_point,
                             ContourScratch& scratch, int face_size, std::span<std::uint8_t> open);

}  // namespace haarfield
