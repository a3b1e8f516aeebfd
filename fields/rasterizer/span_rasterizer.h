#pragma once
/// The general path of the visibility rasterizer: triangles to spans of samples, OR-ed into a bit mask.
///
/// Right for any set of triangles. Everything is in float, in the same order of operations whatever the
/// instruction set, so that every machine gives the same bits.

#include "fields/rasterizer/blocked_samples.h"
#include "fields/rasterizer/viewed_occluder.h"

namespace haarfield {

/// Buffers of block_spans.
struct SpanScratch {
    AlignedBuffer<float>
        vertices;  ///< x, y, z from the view point, never 0, and an outcode (face_outcodes.h).
    AlignedBuffer<std::uint8_t> viewed_vectors;  ///< By vector of vertices: whether it is there.
    AlignedBuffer<float> queue;                  ///< Triangles by face, waiting to be drawn.
    AlignedBuffer<float> edges;                  ///< What drawing needs to know about a batch of triangles.
};

/// Blocks the samples that triangles of the occluder cover, those before one_sided by their front faces
/// alone; clears nothing.
///
/// chosen  a bit per triangle: which.
/// cost    O(triangles / 64 + chosen triangles + covered sub-columns).
void block_spans(const Occluder& occluder, const ViewedOccluder& viewed, const std::uint64_t* chosen,
                 SpanScratch& scratch, BlockedSamples& blocked);

}  // namespace haarfield
