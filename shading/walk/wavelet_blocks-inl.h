// Function products: records the product during a walk and transforms it. Included once per instruction set,
// inside Highway's foreach_target.

#if defined(HAARFIELD_WAVELET_BLOCKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_WAVELET_BLOCKS_INL_H
#undef HAARFIELD_WAVELET_BLOCKS_INL_H
#else
#define HAARFIELD_WAVELET_BLOCKS_INL_H
#endif

#include "shading/walk/square_transform.h"
#include "shading/walk/wavelet_blocks.h"
#include "shading/walk/wide_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Applies transform_square to all quadrants. The vector forms give bit-identical sums and differences.
HWY_INLINE Cells transformed_quadrants(const Cells& cells) {
#if HWY_TARGET == HWY_SCALAR
    alignas(64) float cell[wide_cells];
    store_cells(cells, cell);
    for (std::size_t quadrant = 0; quadrant < wide_cells; quadrant += 4) transform_square(cell + quadrant, 1);
    return load_cells(cell);
#else
    // The cells of a quadrant are one block of 128 bits.
    alignas(16) static constexpr float alternating[] = {1, -1, 1, -1}, halves[] = {1, 1, -1, -1};
    const auto across = hn::LoadDup128(Floats(), alternating), down = hn::LoadDup128(Floats(), halves);
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) {
        const auto pairs = hn::MulAdd(cells.part[i], across, hn::Shuffle2301(cells.part[i]));
        const auto all = hn::MulAdd(pairs, down, hn::Shuffle1032(pairs));
        result.part[i] = hn::Mul(all, hn::Set(Floats(), 0.25f));
    }
    return result;
#endif
}

/// Applies transform_square to the first cells of the quadrants.
HWY_INLINE Cells transformed_means(const Cells& cells) {
#if HWY_MAX_BYTES == 64
    alignas(64) static constexpr float alternating[] = {1, 1, 1, 1, -1, -1, -1, -1,
                                                        1, 1, 1, 1, -1, -1, -1, -1},
                                       halves[] = {1, 1, 1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1, -1, -1};
    const auto values = cells.part[0];
    const auto pairs = hn::MulAdd(values, hn::Load(Floats(), alternating), hn::SwapAdjacentBlocks(values));
    const auto all =
        hn::MulAdd(pairs, hn::Load(Floats(), halves), hn::ConcatLowerUpper(Floats(), pairs, pairs));
    return choose(0x1111, Cells{{hn::Mul(all, hn::Set(Floats(), 0.25f))}}, cells);
#else
    alignas(64) float cell[wide_cells];
    store_cells(cells, cell);
    transform_square(cell, 4);
    return load_cells(cell);
#endif
}

/// Computes the Haar transform of a block's sixteen cells, in the slots of WaveletBlock; the mean comes
/// first.
HWY_INLINE Cells transformed(const Cells& cells) {
    return transformed_means(transformed_quadrants(cells));
}

/// A sink that converts the means of the product over completed cells to wavelets, bottom-up.
///
/// blurs  true: details may be omitted, keeping only the mean of blurred cells.
template <int channels, bool blurs = false>
struct BlockWriter {
    static constexpr unsigned needed = 1;
    static constexpr bool is_sum = false, may_blur = blurs;
    static constexpr float cell_share = 1;

    using Leaves = LeavesOf<BlockWriter>;

    BlockNumbers numbers;
    std::vector<WaveletBlock<channels>>& blocks;
    const DetailWeights* detail = nullptr;  ///< Null: no blurring.
    double blurred_energy = 0;              ///< A bound.
    std::array<std::size_t, 4> place{};     ///< Index of the current block and its ancestors, by level.
    std::array<unsigned, 4> blurred{};      ///< Blurred cells of these blocks.

    bool needs_bounds() const { return detail != nullptr; }
    float negligible(int level) const { return detail->negligible[std::size_t(level)]; }
    void add_blurred(int level, float squares) {
        blurred_energy += double(squares) * double(detail->weight[std::size_t(level)]);
    }
    void set_blurred(int level, unsigned cells) { blurred[std::size_t(level)] = cells; }
    bool is_blurred(int level, std::size_t block) const {
        return level > 0 && (blurred[std::size_t(level) - 1] >> (block % wide_cells) & 1u) != 0;
    }

    /// Adds a block without descendants.
    HWY_INLINE void add(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                        const HeadCells<channels>& head) {
        const Cells share = done == all_sixteen ? product : only(done, product);
        if constexpr (blurs)
            if (is_blurred(level, block)) return add_mean(level, block, share, head);
        WaveletBlock<channels>& added = append(level, face, block);
        for (std::size_t c = 0; c < channels; ++c) {
            if (int(c) >= head.used) {
                store_cells(all_cells(0), added.amplitude[c].data());
                continue;
            }
            const Cells slots = transformed(share * head.value[c]);
            store_cells(slots, added.amplitude[c].data());
            if (level > 0) blocks[added.parent].amplitude[c][added.cell] = first_cell(slots);
        }
    }
    HWY_INLINE void open(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                         const HeadCells<channels>& head) {
        const Cells share = only(done, product);
        if constexpr (blurs)
            if (is_blurred(level, block)) return add_mean(level, block, share, head);
        WaveletBlock<channels>& added = append(level, face, block);
        for (std::size_t c = 0; c < channels; ++c)
            store_cells(share * head.value[c], added.amplitude[c].data());
    }
    HWY_INLINE void close(int level, [[maybe_unused]] std::size_t block) {
        if constexpr (blurs)
            if (is_blurred(level, block)) return;
        WaveletBlock<channels>& whole = blocks[place[std::size_t(level)]];
        for (std::size_t c = 0; c < channels; ++c) {
            const Cells slots = transformed(load_cells(whole.amplitude[c].data()));
            store_cells(slots, whole.amplitude[c].data());
            if (level > 0) blocks[whole.parent].amplitude[c][whole.cell] = first_cell(slots);
        }
    }

private:
    HWY_INLINE WaveletBlock<channels>& append(int level, std::size_t face, std::size_t block) {
        const std::size_t here = place[std::size_t(level)] = blocks.size();
        WaveletBlock<channels>& added = blocks.emplace_back();
        added.block = static_cast<std::uint32_t>(numbers(level, face, block));
        added.parent = static_cast<std::uint32_t>(level == 0 ? here : place[std::size_t(level) - 1]);
        added.cell = static_cast<std::uint16_t>(block % wide_cells);
        added.level = static_cast<std::uint16_t>(level);
        return added;
    }

    /// Adds a block's mean to the blurred cell that contains it.
    void add_mean(int level, std::size_t block, const Cells& share, const HeadCells<channels>& head) {
        float part = 1.0f / wide_cells;
        for (--level; is_blurred(level, block / wide_cells); --level) {
            block /= wide_cells;
            part /= wide_cells;
        }
        WaveletBlock<channels>& above = blocks[place[std::size_t(level)]];
        for (std::size_t c = 0; c < channels; ++c)
            above.amplitude[c][block % wide_cells] += sum_of(share * head.value[c]) * part;
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
