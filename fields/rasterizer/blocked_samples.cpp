#include "fields/rasterizer/blocked_samples.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "fields/rasterizer/visibility_rasterizer.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fields/rasterizer/blocked_samples.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Words = hn::CappedTag<std::uint64_t, 8>;
using Bytes = hn::CappedTag<std::uint8_t, 64>;

/// Swaps the bits of b under the mask with the bits of a above it, `shift` positions higher.
template <int shift, class DU, class V>
HWY_INLINE void exchange(DU d, V& a, V& b, std::uint64_t mask) {
    const V t = hn::And(hn::Xor(hn::ShiftRight<shift>(a), b), hn::Set(d, mask));
    b = hn::Xor(b, t);
    a = hn::Xor(a, hn::ShiftLeft<shift>(t));
}

/// Transposes 8 x 8 bytes, one block per lane: byte r of row c becomes byte c of row r.
template <class DU, class V>
HWY_INLINE void transpose_bytes(DU d, V (&rows)[8]) {
    for (int i = 0; i < 4; ++i) exchange<32>(d, rows[i], rows[i + 4], 0x00000000ffffffff);
    for (const int i : {0, 1, 4, 5}) exchange<16>(d, rows[i], rows[i + 2], 0x0000ffff0000ffff);
    for (const int i : {0, 2, 4, 6}) exchange<8>(d, rows[i], rows[i + 1], 0x00ff00ff00ff00ff);
}

/// Transposes 8 x 8 bits, one block in each byte of a lane: bit r of row c becomes bit c of row r.
template <class DU, class V>
HWY_INLINE void transpose_bits(DU d, V (&rows)[8]) {
    for (int i = 0; i < 4; ++i) exchange<4>(d, rows[i], rows[i + 4], 0x0f0f0f0f0f0f0f0f);
    for (const int i : {0, 1, 4, 5}) exchange<2>(d, rows[i], rows[i + 2], 0x3333333333333333);
    for (const int i : {0, 2, 4, 6}) exchange<1>(d, rows[i], rows[i + 1], 0x5555555555555555);
}

/// Adds eight texel columns of a strip of spans to the texels, whose rows are `size` apart.
void add_spans(const std::uint64_t* words, std::size_t column_count, std::size_t rows, std::size_t size,
               std::uint8_t* texels) {
    const Words d;
    std::uint64_t any = 0;
    for (std::size_t k = 0; k < samples_per_texel * column_count; ++k) any |= words[k];
    if (any == 0) return;
    // Indexed by sub-column of a texel: the words of eight texel columns.
    alignas(64) std::uint64_t sub_columns[8][8] = {}, turned[8][8];
    for (std::size_t c = 0; c < column_count; ++c)
        for (std::size_t j = 0; j < 8; ++j) sub_columns[j][c] = words[8 * c + j];
    // Indexed by the lowest three bits of the row: words whose bytes are indexed by its upper three bits.
    for (std::size_t c = 0; c < 8; c += hn::Lanes(d)) {
        hn::Vec<Words> block[8];
        for (std::size_t j = 0; j < 8; ++j) block[j] = hn::Load(d, sub_columns[j] + c);
        transpose_bits(d, block);
        for (std::size_t r = 0; r < 8; ++r) hn::Store(block[r], d, turned[r] + c);
    }
    // Indexed by row: words whose bytes are indexed by texel column.
    alignas(64) std::uint64_t by_row[8][8];
    for (std::size_t low = 0; low < 8; low += hn::Lanes(d)) {
        hn::Vec<Words> block[8];
        for (std::size_t c = 0; c < 8; ++c) {
            alignas(64) std::uint64_t lanes[8];
            for (std::size_t i = 0; i < hn::Lanes(d); ++i) lanes[i] = turned[low + i][c];
            block[c] = hn::Load(d, lanes);
        }
        transpose_bytes(d, block);
        for (std::size_t high = 0; high < 8; ++high) hn::Store(block[high], d, by_row[high] + low);
    }
    for (std::size_t r = 0; r < rows; ++r) {  // columns beyond the last are zero
        std::uint64_t eight;
        std::memcpy(&eight, texels + r * size, sizeof eight);
        eight |= by_row[r / 8][r % 8];
        std::memcpy(texels + r * size, &eight, sizeof eight);
    }
}

void count_open(BlockedSamples& blocked, std::uint8_t* open) {
    const Bytes d;
    const auto size = static_cast<std::size_t>(blocked.face_size);
    const std::size_t face_texels = size * size;
    using Contours = BlockedSamples::Contours;
    for (int face = 0; face < cubemap_faces; ++face, open += face_texels) {
        Contours& contours = blocked.contoured_faces[std::size_t(face)];
        std::uint8_t* texels = blocked.texels(face);
        if (blocked.spanned_faces >> face & 1) {
            if (contours == Contours::block_nothing) std::memset(texels, 0, face_texels);
            if (contours != Contours::block_all) contours = Contours::vary;
            for (std::size_t s = 0; s < blocked.strips; ++s) {
                std::uint64_t* words = blocked.strip(face, int(s));
                for (std::size_t c = 0; contours == Contours::vary && c < size; c += 8)
                    add_spans(words + samples_per_texel * c, std::min<std::size_t>(8, size - c),
                              std::min<std::size_t>(64, size - 64 * s), size, texels + 64 * s * size + c);
                std::memset(words, 0, blocked.stride * sizeof(std::uint64_t));
            }
        }
        if (contours == Contours::vary)
            for (std::size_t i = 0; i < face_texels; i += hn::Lanes(d))
                hn::StoreU(hn::Sub(hn::Set(d, std::uint8_t(samples_per_texel)),
                                   hn::PopulationCount(hn::LoadU(d, texels + i))),
                           d, open + i);
        else
            std::memset(open, contours == Contours::block_all ? 0 : samples_per_texel, face_texels);
        contours = Contours::block_nothing;
    }
    blocked.spanned_faces = 0;
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(count_open);

BlockedSamples::BlockedSamples(int size)
    : face_size(size),
      strips((std::size_t(size) + 63) / 64),
      stride(std::max<std::size_t>(samples_per_texel * std::size_t(size), 64)) {
    spans.reserve(cubemap_faces * strips * stride);
    contours.reserve(std::size_t(cubemap_faces * size) * std::size_t(size) + widest_vector<std::uint8_t>);
}

void add_contours(const BlockedSamples& others, BlockedSamples& to) {
    using Contours = BlockedSamples::Contours;
    for (int face = 0; face < cubemap_faces; ++face) {
        const Contours from = others.contoured_faces[std::size_t(face)];
        Contours& contours = to.contoured_faces[std::size_t(face)];
        const std::uint8_t* more = others.texels(face);
        std::uint8_t* texels = to.texels(face);
        if (contours == Contours::vary && from == Contours::vary)
            for (std::size_t i = 0; i < to.face_texels(); i += 8) {
                std::uint64_t eight, eight_more;
                std::memcpy(&eight, texels + i, 8);
                std::memcpy(&eight_more, more + i, 8);
                eight |= eight_more;
                std::memcpy(texels + i, &eight, 8);
            }
        else if (contours == Contours::block_nothing && from == Contours::vary)
            std::memcpy(texels, more, to.face_texels());
        if (contours != Contours::block_all && from != Contours::block_nothing) contours = from;
    }
}

void count_open_samples(BlockedSamples& blocked, std::uint8_t* open) {
    HWY_DYNAMIC_DISPATCH(count_open)(blocked, open);
}

}  // namespace haarfield
#endif
