#include "shading/visibility/texel_blocks.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <numeric>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/visibility/texel_blocks.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Positions, row by row, of the texels that become the cells of a block.
alignas(16) constexpr std::uint8_t cells_of_rows[wide_cells] = {0, 1, 4,  5,  2,  3,  6,  7,
                                                                8, 9, 12, 13, 10, 11, 14, 15};

#if HWY_TARGET == HWY_SCALAR

using Block = std::array<std::uint8_t, wide_cells>;

/// Loads four adjacent squares of 4 x 4 texels as cells.
void load_squares(const std::uint8_t* corner, std::size_t stride, Block* squares) {
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t cell = 0; cell < wide_cells; ++cell)
            squares[k][cell] = corner[cells_of_rows[cell] / 4 * stride + cells_of_rows[cell] % 4 + 4 * k];
}

/// Returns four of the cells, each repeated four times.
Block quarter(const Block& cells, std::size_t q) {
    Block result;
    for (std::size_t cell = 0; cell < wide_cells; ++cell) result[cell] = cells[4 * q + cell / 4];
    return result;
}

void write_block(const Block& open, std::size_t index, TexelBlocks& blocks) {
    blocks.mean[index] = open;
    blocks.squares.open[index] = std::accumulate(open.begin(), open.end(), 0u);
    blocks.squares.varies[index] =
        std::all_of(open.begin(), open.end(), [&](std::uint8_t o) { return o == open[0]; }) ? 0 : 1;
}

#else

using Bytes = hn::FixedTag<std::uint8_t, wide_cells>;
using Block = hn::Vec<Bytes>;

/// Loads four adjacent squares of 4 x 4 texels as cells.
HWY_INLINE void load_squares(const std::uint8_t* corner, std::size_t stride, Block* squares) {
    const Bytes d;
    const hn::Repartition<std::uint32_t, Bytes> words;
    const hn::Repartition<std::uint64_t, Bytes> pairs;
    const auto row = [&](std::size_t k) { return hn::BitCast(words, hn::LoadU(d, corner + k * stride)); };
    const auto row0 = row(0), row1 = row(1), row2 = row(2), row3 = row(3);
    const auto upper_left = hn::BitCast(pairs, hn::InterleaveLower(words, row0, row1)),
               upper_right = hn::BitCast(pairs, hn::InterleaveUpper(words, row0, row1)),
               lower_left = hn::BitCast(pairs, hn::InterleaveLower(words, row2, row3)),
               lower_right = hn::BitCast(pairs, hn::InterleaveUpper(words, row2, row3));
    squares[0] = hn::BitCast(d, hn::InterleaveLower(pairs, upper_left, lower_left));
    squares[1] = hn::BitCast(d, hn::InterleaveUpper(pairs, upper_left, lower_left));
    squares[2] = hn::BitCast(d, hn::InterleaveLower(pairs, upper_right, lower_right));
    squares[3] = hn::BitCast(d, hn::InterleaveUpper(pairs, upper_right, lower_right));
    const Block order = hn::Load(d, cells_of_rows);
    for (std::size_t k = 0; k < 4; ++k) squares[k] = hn::TableLookupBytes(squares[k], order);
}

/// Returns four of the cells, each repeated four times.
HWY_INLINE Block quarter(const Block& cells, std::size_t q) {
    const Bytes d;
    alignas(16) static constexpr std::uint8_t first[wide_cells] = {0, 0, 0, 0, 1, 1, 1, 1,
                                                                   2, 2, 2, 2, 3, 3, 3, 3};
    const Block from = hn::Add(hn::Load(d, first), hn::Set(d, static_cast<std::uint8_t>(4 * q)));
    return hn::TableLookupBytes(cells, from);
}

HWY_INLINE void write_block(const Block& open, std::size_t index, TexelBlocks& blocks) {
    const Bytes d;
    const hn::Repartition<std::uint64_t, Bytes> sums;
    hn::StoreU(open, d, blocks.mean[index].data());
    blocks.squares.open[index] =
        static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(sums, hn::SumsOf8(open))));
    const Block first = hn::TableLookupBytes(open, hn::Zero(d));
    blocks.squares.varies[index] = hn::AllTrue(d, hn::Eq(open, first)) ? 0 : 1;
}

#endif

/// Inserts a zero after each bit of a number below 256.
constexpr std::size_t spread(std::size_t number) {
    number = (number | number << 4) & 0x0f0f;
    number = (number | number << 2) & 0x3333;
    return (number | number << 1) & 0x5555;
}

/// edge: of the face, in squares of 4 x 4 texels. stride: from row to row, at least 16.
template <bool is_quartered>
void write_squares(const std::uint8_t* texels, std::size_t stride, std::size_t edge, TexelBlocks& blocks) {
    for (std::size_t y = 0; y < edge; ++y)
        for (std::size_t x = 0; x < edge; x += 4) {
            Block squares[4];
            load_squares(texels + 4 * (y * stride + x), stride, squares);
            for (std::size_t k = 0; k < 4 && x + k < edge; ++k) {
                const std::size_t path = spread(x + k) | spread(y) << 1;
                if constexpr (is_quartered)
                    for (std::size_t q = 0; q < 4 && 4 * path + q < blocks.mean.size(); ++q)
                        write_block(quarter(squares[k], q), 4 * path + q, blocks);
                else
                    write_block(squares[k], path, blocks);
            }
        }
}

void write_face(const std::uint8_t* texels, std::size_t stride, std::size_t edge, bool is_quartered,
                TexelBlocks& blocks) {
    if (is_quartered)
        write_squares<true>(texels, stride, edge, blocks);
    else
        write_squares<false>(texels, stride, edge, blocks);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(write_face);

void sort_into_blocks(std::span<const std::uint8_t> open, int face_size, TexelBlocks& blocks) {
    const auto size = static_cast<std::size_t>(face_size);
    assert(size >= 2 && open.size() == size * size);
    const bool is_quartered = std::countr_zero(size) % 2 != 0;
    const std::size_t count = is_quartered ? size * size / 4 : size * size / wide_cells;
    blocks.mean.resize(count);
    blocks.squares.open.resize(count);
    blocks.squares.varies.resize(count);
    // Rows of small faces are padded to the length of a load.
    constexpr std::size_t least_stride = 16;
    std::array<std::uint8_t, least_stride * least_stride> widened{};
    if (size < least_stride) {
        for (std::size_t row = 0; row < size; ++row)
            std::copy_n(&open[row * size], size, &widened[row * least_stride]);
        open = widened;
    }
    HWY_DYNAMIC_DISPATCH(write_face)
    (open.data(), std::max(size, least_stride), std::max(size / 4, std::size_t(1)), is_quartered, blocks);
}

}  // namespace haarfield
#endif
