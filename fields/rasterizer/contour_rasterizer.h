#pragma once
/// The fast path of the visibility rasterizer: only the edges where the number of layers changes matter.

#include "fields/rasterizer/blocked_samples.h"
#include "fields/rasterizer/viewed_occluder.h"
#include "fields/rasterizer/visible_contour.h"

namespace haarfield {

/// Buffers of block_contour.
struct ContourScratch {
    AlignedBuffer<float> columns;                           ///< Where the sub-columns are.
    AlignedBuffer<float> lines;                             ///< Contour edges on a face;
    AlignedBuffer<std::uint32_t> wide;                      ///< those of many sub-columns;
    std::array<AlignedBuffer<std::uint32_t>, 2> crossings;  ///< places in the counters that they change.
    AlignedBuffer<std::uint8_t> counters;  ///< Changes of the number of layers: texel row, sub-column;
    AlignedBuffer<std::uint8_t> starts;    ///< and above the first row, from sub-column to sub-column.
};

/// Blocks the samples that lie inside of a contour; the masks must be clear.
///
/// returns  false, and leaves them clear, where there may be more than 255 layers or a face has less than 8
///          texels along an edge.
/// cost     O(contour edges + crossed sub-columns + texels of faces that the contour crosses).
bool block_contour(const Occluder& occluder, const ViewedOccluder& viewed, const VisibleContour& contour,
                   ContourScratch& scratch, BlockedSamples& blocked);

}  // namespace haarfield
