#pragma once
/// The blocked samples of a cubemap, as the two paths of the visibility rasterizer leave them.

#include <array>
#include <cstdint>

#include "fields/base/aligned_buffer.h"
#include "fields/wavelets/cubemap.h"

namespace haarfield {

/// Two masks, a bit a sample; blocked is what either has. Sub-column 8 c + j runs down through texel column c
/// and has one sample in each texel row r.
///
/// Spans     by face; strip of 64 texel rows; sub-column: a word, whose bits are the rows of the strip.
/// Contours  by face; texel row; texel column: a byte, whose bits are the sub-columns.
struct BlockedSamples {
    explicit BlockedSamples(int face_size);  ///< None is blocked.

    /// Where the sub-columns of a strip begin.
    std::uint64_t* strip(int face, int strip_index) {
        return spans.data() + (std::size_t(face) * strips + std::size_t(strip_index)) * stride;
    }
    /// Where the texels of a face begin.
    std::uint8_t* texels(int face) { return contours.data() + std::size_t(face) * face_texels(); }
    /// Of one face.
    const std::uint8_t* texels(int face) const { return contours.data() + std::size_t(face) * face_texels(); }
    /// Texels of a face.
    std::size_t face_texels() const { return std::size_t(face_size) * std::size_t(face_size); }

    /// What the contours leave of a face; the texels count only if they vary.
    enum class Contours : std::uint8_t { block_nothing, block_all, vary };

    int face_size;
    std::size_t strips;          ///< Per face.
    std::size_t stride;          ///< Words from strip to strip: 8 face_size, at least a vector's length.
    unsigned spanned_faces = 0;  ///< Bit per face: set if spans may have a blocked sample there.
    AlignedBuffer<std::uint64_t> spans;
    std::array<Contours, cubemap_faces> contoured_faces{};
    AlignedBuffer<std::uint8_t> contours;
};

/// Blocks what the contours of others block, too; the spans are left alone. Faces of at least 8 texels along
/// an edge, as block_contour has them.
void add_contours(const BlockedSamples& others, BlockedSamples& to);

/// Open samples of each texel, face by face and row by row; leaves nothing blocked.
///
/// open  6 face_size^2 counts, and room for 64 more.
void count_open_samples(BlockedSamples& blocked, std::uint8_t* open);

}  // namespace haarfield
