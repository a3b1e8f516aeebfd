// Function products: what a walk finds, written down and transformed. Included once per instruction set,
// inside Highway's foreach_target.

#if defined(HAARFIELD_WAVELET_BLOCKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_WAVELET_BLOCKS_INL_H
#undef HAARFIELD_WAVELET_BLOCKS_INL_H
#else
#define HAARFIELD_WAVELET_BLOCKS_INL_H
#endif

#include "shading/square_transform.h"
#include "shading/wide_product.h"
#include "shading/wide_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Sink of a walk: the means of the product over the cells that are done.
///
/// blurs  whether details may be left out: of blurred cells only the mean is kept.
template <int channels, bool blurs = false>
struct BlockWriter {
    static constexpr unsigned needed = 1;
    static constexpr bool may_prune = false, may_blur = blurs;
    static constexpr float cell_share = 1;

    BlockNumbers numbers;
    std::vector<WaveletBlock<channels>>& blocks;
    const DetailWeights* detail = nullptr;  ///< Null: nothing is blurred.
    double blurred_energy = 0;              ///< A bound.
    std::array<std::size_t, 4> place{};     ///< Of the block at hand and those above, by level.
    std::array<unsigned, 4> blurred{};      ///< Of these, the cells.

    bool needs_bounds() const { return detail != nullptr; }
    float negligible(int level) const { return detail->negligible[std::size_t(level)]; }
    void add_blurred(int level, float squares) {
        blurred_energy += double(squares) * double(detail->weight[std::size_t(level)]);
    }
    void set_blurred(int level, unsigned cells) { blurred[std::size_t(level)] = cells; }
    bool is_blurred(int level, std::size_t block) const {
        return level > 0 && (blurred[std::size_t(level) - 1] >> (block % wide_cells) & 1u) != 0;
    }

    HWY_INLINE void visit(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                          const HeadCells<channels>& head) {
        const Cells share = only(done, product);
        if constexpr (blurs)
            if (is_blurred(level, block)) return add_mean(level, block, share, head);
        const std::size_t here = place[std::size_t(level)] = blocks.size();
        const std::size_t parent = level == 0 ? here : place[std::size_t(level) - 1];
        WaveletBlock<channels>& added = blocks.emplace_back();
        added.block = static_cast<std::uint32_t>(numbers(level, face, block));
        added.parent = static_cast<std::uint32_t>(parent);
        added.cell = static_cast<std::uint32_t>(block % wide_cells);
        for (std::size_t c = 0; c < channels; ++c)
            store_cells(share * head.value[c], added.amplitude[c].data());
    }

private:
    /// To the blurred cell that the block lies in.
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

/// transform_square of all quadrants. Sums and differences are the same bits in vectors.
HWY_INLINE void transform_quadrants(float* cell) {
#if HWY_TARGET == HWY_SCALAR
    for (std::size_t quadrant = 0; quadrant < wide_cells; quadrant += 4) transform_square(cell + quadrant, 1);
#else
    // The cells of a quadrant are one block of 128 bits.
    alignas(16) static constexpr float alternating[] = {1, -1, 1, -1}, halves[] = {1, 1, -1, -1};
    const auto across = hn::LoadDup128(Floats(), alternating), down = hn::LoadDup128(Floats(), halves);
    const Cells cells = load_cells(cell);
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) {
        const auto pairs = hn::MulAdd(cells.part[i], across, hn::Shuffle2301(cells.part[i]));
        const auto all = hn::MulAdd(pairs, down, hn::Shuffle1032(pairs));
        result.part[i] = hn::Mul(all, hn::Set(Floats(), 0.25f));
    }
    store_cells(result, cell);
#endif
}

/// transform_cells.
HWY_INLINE float transform_cells_in_vectors(std::array<float, wide_cells>& cell) {
    transform_quadrants(cell.data());
    transform_square(cell.data(), 4);
    return cell[0];
}

/// From the means of the product to its wavelets, bottom-up.
template <int channels>
void transform_blocks(std::vector<WaveletBlock<channels>>& blocks) {
    for (std::size_t i = blocks.size(); i-- > 0;)
        for (std::size_t c = 0; c < channels; ++c) {
            const float mean = transform_cells_in_vectors(blocks[i].amplitude[c]);
            if (blocks[i].parent != i) blocks[blocks[i].parent].amplitude[c][blocks[i].cell] = mean;
        }
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
