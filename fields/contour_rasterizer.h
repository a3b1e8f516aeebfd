#pragma once
/// The fast path of the visibility rasterizer: only the edges where the number of layers changes matter.

#include "fields/blocked_samples.h"
#include "fields/viewed_occluder.h"
#include "fields/visible_contour.h"

namespace haarfield {

/// Buffers of block_contour.
struct ContourScratch {
    AlignedBuffer<float> columns;            ///< Where the sub-columns are.
    AlignedBuffer<std::uint32_t> of_face;    ///< The contour edges that matter to a face.
    AlignedBuffer<float> queue, lines;       ///< Some of them, and their lines on the face.
    AlignedBuffer<std::uint32_t> crossings;  ///< Places in the counters that these change,
    AlignedBuffer<std::uint8_t> changes;     ///< and by how much.
    AlignedBuffer<std::uint8_t> counters;    ///< Changes of the number of layers: texel row, sub-column.
};

/// Blocks the samples that lie inside of a contour; the masks must be clear.
///
/// returns  false, and leaves them clear, where there may be more than 255 layers or a face has less than 8
///          texels along an edge.
/// cost     O(contour edges + crossed sub-columns + texels of faces that the contour crosses).
bool block_contour(const Occluder& occluder, const ViewedOccluder& viewed, const VisibleContour& contour,
                   ContourScratch& scratch, BlockedSamples& blocked);

}  // namespace haarfield
