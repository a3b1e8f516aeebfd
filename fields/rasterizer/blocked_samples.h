#pragma once
/// The blocked samples of a cubemap, as the two paths of the visibility rasterizer write them.

#include <array>
#include <cstdint>

#include "fields/base/aligned_buffer.h"
#include "fields/wavelets/cubemap.h"

namespace haarfield {

/// Two masks with one bit per sample. A sample is blocked if it is set in either mask. Sub-column 8 c + j
/// runs down through texel column c and has one sample in each texel row r.
///
/// Spans     indexed by face, strip of 64 texel rows and sub-column: one word, whose bits are the rows of the
///           strip.
/// Contours  indexed by face, texel row and texel column: one byte, whose bits are the sub-columns.
struct BlockedSamples {
    explicit BlockedSamples(int face_size);  ///< No sample is blocked.

    /// Returns the sub-columns of a strip.
    std::uint64_t* strip(int face, int strip_index) {
        return spans.data() + (std::size_t(face) * strips + std::size_t(strip_index)) * stride;
    }
    /// Returns the texels of a face.
    std::uint8_t* texels(int face) { return contours.data() + std::size_t(face) * face_texels(); }
    /// Returns the texels of a face.
    const std::uint8_t* texels(int face) const { return contours.data() + std::size_t(face) * face_texels(); }
    /// The number of texels of a face.
    std::size_t face_texels() const { return std::size_t(face_size) * std::size_t(face_size); }

    /// The effect of the contours on a face. The texels are valid only for `vary`.
    enum class Contours : std::uint8_t { block_nothing, block_all, vary };

    int face_size;
    std::size_t strips;          ///< Per face.
    std::size_t stride;          ///< Words between strips: 8 face_size, at least a vector's length.
    unsigned spanned_faces = 0;  ///< One bit per face: set if spans may have blocked samples on it.
    AlignedBuffer<std::uint64_t> spans;
    std::array<Contours, cubemap_faces> contoured_faces{};
    AlignedBuffer<std::uint8_t> contours;
};

/// Blocks the samples that the contours of `others` block. Leaves the spans unchanged. Faces must have at
/// least 8 texels along an edge, as in block_contour.
void add_contours(const BlockedSamples& others, BlockedSamples& to);

/// Counts the open samples of each texel, face by face in row-major order. Then clears all blocked samples.
///
/// open  6 face_size^2 counts, with padding for 64 more.
void count_open_samples(BlockedSamples& blocked, std::uint8_t* open);

}  // namespace haarfield
