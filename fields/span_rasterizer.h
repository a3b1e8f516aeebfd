#pragma once
/// The general path of the visibility rasterizer: triangles to spans of samples, OR-ed into a bit mask.
///
/// Right for any set of triangles. Everything is in float, in the same order of operations whatever the
/// instruction set, so that every machine gives the same bits.

#include "fields/occluder.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <new>

namespace haarfield {

/// Plain numbers in memory that starts a cache line, so that no vector straddles two.
template <class T>
class AlignedBuffer {
public:
    /// At least this many elements; they are zeros after growth, and otherwise what they were.
    void reserve(std::size_t count) {
        if (count <= count_) return;
        values_.reset(static_cast<T*>(::operator new(count * sizeof(T), alignment)));
        std::fill_n(values_.get(), count, T(0));
        count_ = count;
    }
    T* data() { return values_.get(); }
    const T* data() const { return values_.get(); }

private:
    static constexpr std::align_val_t alignment{64};
    struct Free {
        void operator()(T* values) const { ::operator delete(values, alignment); }
    };
    std::unique_ptr<T, Free> values_;
    std::size_t count_ = 0;
};

/// The blocked samples of a cubemap, a bit each, in sub-columns: sub-column 8 c + j runs down through texel
/// column c and has one sample in each texel row r.
///
/// Layout: face; strip of 64 texel rows; sub-column; bit: the row in the strip.
struct BlockedSamples {
    explicit BlockedSamples(int face_size);

    /// Where the sub-columns of a strip begin.
    std::uint64_t* strip(int face, int strip_index) {
        return bits.data() + (std::size_t(face) * strips + std::size_t(strip_index)) * stride;
    }

    int face_size;
    std::size_t strips;    ///< Per face.
    std::size_t stride;    ///< Words from strip to strip: 8 face_size, at least a vector's length.
    unsigned touched = 0;  ///< Bit per face: set if it may have a blocked sample.
    AlignedBuffer<std::uint64_t> bits;
};

/// An occluder as it is seen from a view point.
struct ViewedOccluder {
    bool horizon = false;                 ///< Whether there is one.
    AlignedBuffer<float> vertices;        ///< x, y, z from the view point, and an outcode (view_frame.h).
    AlignedBuffer<std::uint64_t> facing;  ///< By 64 triangles: a word of those seen from the front, one of
                                          ///< those from the back; those seen edge-on are in neither.
};

/// horizon  as VisibilityRasterizer's: sets a bit of the outcodes.
/// cost     O(vertices + triangles), less than a nanosecond each.
void look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon, ViewedOccluder& viewed);

/// Buffers of block_spans.
struct SpanScratch {
    AlignedBuffer<float> queue;  ///< Triangles by face, waiting to be drawn.
    AlignedBuffer<float> edges;  ///< What drawing needs to know about a batch of triangles.
};

/// Blocks the samples that triangles [first, last) of the occluder cover, those before one_sided by their
/// front faces alone; clears nothing.
///
/// cost  O(triangles + covered sub-columns).
void block_spans(const Occluder& occluder, std::uint32_t first, std::uint32_t last,
                 const ViewedOccluder& viewed, SpanScratch& scratch, BlockedSamples& blocked);

/// Open samples of each texel, face by face and row by row; clears the mask.
void count_open_samples(BlockedSamples& blocked, std::uint8_t* open);

}  // namespace haarfield
