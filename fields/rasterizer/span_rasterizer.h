#pragma once
/// The general path of the visibility rasterizer: converts triangles to spans of samples in a bit mask.
///
/// Correct for any set of triangles. All arithmetic is in float, in the same order for every instruction set,
/// so that results are bit-identical on all machines.

#include "fields/rasterizer/blocked_samples.h"
#include "fields/rasterizer/viewed_occluder.h"

namespace haarfield {

/// Buffers of block_spans.
struct SpanScratch {
    /// x, y, z relative to the view point, never 0, and an outcode (face_outcodes.h).
    AlignedBuffer<float> vertices;
    AlignedBuffer<std::uint8_t> viewed_vectors;  ///< One per vector of vertices: 1 once transformed.
    AlignedBuffer<float> queue;                  ///< Triangles waiting to be drawn, by face.
    AlignedBuffer<float> edges;                  ///< Drawing data of a batch of triangles (EdgeData).
};

/// Blocks the samples that triangles of the occluder cover. Triangles before one_sided() block with their
/// front faces only. Does not clear samples.
///
/// chosen  one bit per triangle: set to draw it.
/// cost    O(triangles / 64 + chosen triangles + covered sub-columns).
void block_spans(const Occluder& occluder, const ViewedOccluder& viewed, const std::uint64_t* chosen,
                 SpanScratch& scratch, BlockedSamples& blocked);

}  // namespace haarfield
