#pragma once
/// The fast path of the visibility rasterizer: draws only edges at which the number of layers changes.

#include "fields/rasterizer/blocked_samples.h"
#include "fields/rasterizer/turned_poles.h"
#include "fields/rasterizer/viewed_occluder.h"
#include "fields/rasterizer/visible_contour.h"

namespace haarfield {

/// Buffers of block_contour.
struct ContourScratch {
    AlignedBuffer<float> columns;                           ///< Positions of the sub-columns.
    AlignedBuffer<float> lines;                             ///< Contour edges on a face.
    AlignedBuffer<std::uint32_t> wide;                      ///< Numbers of lines wider than a texel.
    std::array<AlignedBuffer<std::uint32_t>, 2> crossings;  ///< Indices of the counters to change.
    AlignedBuffer<std::uint8_t> counters;  ///< Changes of the number of layers, by texel row and sub-column.
    AlignedBuffer<std::uint8_t> starts;    ///< Changes above the first row, by sub-column.
    TurnedPoles turned_poles;              ///< Of the current view, if it is turned.
};

/// Blocks the samples inside a contour. The masks must be clear.
///
/// returns  false, with the masks still clear, if there may be more than 255 layers or a face has less than 8
///          texels along an edge.
/// cost     O(contour edges + crossed sub-columns + texels of faces that the contour crosses).
bool block_contour(const Occluder& occluder, const ViewedOccluder& viewed, const VisibleContour& contour,
                   ContourScratch& scratch, BlockedSamples& blocked);

}  // namespace haarfield
