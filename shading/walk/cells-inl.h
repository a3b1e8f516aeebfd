// The sixteen cells of a block (wide_tree.h) in the number of vectors that the instruction set needs.
// Included once per instruction set, inside Highway's foreach_target.

#if defined(HAARFIELD_CELLS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_CELLS_INL_H
#undef HAARFIELD_CELLS_INL_H
#else
#define HAARFIELD_CELLS_INL_H
#endif

#include <hwy/highway.h>

#include "shading/walk/wide_tree.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, wide_cells>;
inline constexpr std::size_t cells_per_part = hn::MaxLanes(Floats());
inline constexpr std::size_t parts = wide_cells / cells_per_part;

struct Cells {
    hn::Vec<Floats> part[parts];
};

HWY_INLINE Cells all_cells(float value) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Set(Floats(), value);
    return result;
}

HWY_INLINE Cells load_cells(const float* from) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::LoadU(Floats(), from + i * cells_per_part);
    return result;
}

HWY_INLINE Cells load_cells(const std::uint8_t* from) {
    const hn::Rebind<std::uint8_t, Floats> bytes;
    const hn::Rebind<std::int32_t, Floats> words;
    Cells result;
    for (std::size_t i = 0; i < parts; ++i)
        result.part[i] =
            hn::ConvertTo(Floats(), hn::PromoteTo(words, hn::LoadU(bytes, from + i * cells_per_part)));
    return result;
}

HWY_INLINE void store_cells(const Cells& cells, float* to) {
    for (std::size_t i = 0; i < parts; ++i) hn::StoreU(cells.part[i], Floats(), to + i * cells_per_part);
}

HWY_INLINE Cells operator*(const Cells& a, const Cells& b) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Mul(a.part[i], b.part[i]);
    return result;
}

HWY_INLINE Cells operator+(const Cells& a, const Cells& b) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Add(a.part[i], b.part[i]);
    return result;
}

HWY_INLINE Cells operator-(const Cells& a, const Cells& b) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Sub(a.part[i], b.part[i]);
    return result;
}

HWY_INLINE Cells operator/(const Cells& a, const Cells& b) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Div(a.part[i], b.part[i]);
    return result;
}

HWY_INLINE Cells larger(const Cells& a, const Cells& b) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Max(a.part[i], b.part[i]);
    return result;
}

HWY_INLINE Cells smaller(const Cells& a, const Cells& b) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Min(a.part[i], b.part[i]);
    return result;
}

/// Returns a b + c.
HWY_INLINE Cells multiply_add(const Cells& a, const Cells& b, const Cells& c) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::MulAdd(a.part[i], b.part[i], c.part[i]);
    return result;
}

HWY_INLINE float first_cell(const Cells& values) {
    return hn::GetLane(values.part[0]);
}

/// Returns one vector's portion of a mask of cells.
HWY_INLINE hn::Mask<Floats> part_of(unsigned cells, std::size_t part) {
    const std::uint64_t bits = cells >> (part * cells_per_part);
    std::uint8_t bytes[8];
    hwy::CopyBytes<8>(&bits, bytes);
    return hn::LoadMaskBits(Floats(), bytes);
}

/// Keeps the selected cells and sets the others to zero.
HWY_INLINE Cells only(unsigned cells, const Cells& values) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i)
        result.part[i] = hn::IfThenElseZero(part_of(cells, i), values.part[i]);
    return result;
}

HWY_INLINE Cells choose(unsigned cells, const Cells& if_set, const Cells& if_clear) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i)
        result.part[i] = hn::IfThenElse(part_of(cells, i), if_set.part[i], if_clear.part[i]);
    return result;
}

/// Keeps cells with values up to a bound and sets the others to zero.
HWY_INLINE Cells only_up_to(float bound, const Cells& values) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i)
        result.part[i] = hn::IfThenElseZero(hn::Le(values.part[i], hn::Set(Floats(), bound)), values.part[i]);
    return result;
}

HWY_INLINE unsigned bits_of(const hn::Mask<Floats>* masks) {
    unsigned result = 0;
    for (std::size_t i = 0; i < parts; ++i) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(Floats(), masks[i], bytes);
        result |= (bytes[0] | unsigned(bytes[1]) << 8) << (i * cells_per_part);
    }
    return result;
}

HWY_INLINE unsigned cells_that_are_zero(const Cells& values) {
    hn::Mask<Floats> masks[parts];
    for (std::size_t i = 0; i < parts; ++i) masks[i] = hn::Eq(values.part[i], hn::Zero(Floats()));
    return bits_of(masks);
}

HWY_INLINE unsigned cells_above(const Cells& values, float bound) {
    hn::Mask<Floats> masks[parts];
    for (std::size_t i = 0; i < parts; ++i) masks[i] = hn::Gt(values.part[i], hn::Set(Floats(), bound));
    return bits_of(masks);
}

HWY_INLINE Cells square_root(const Cells& values) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Sqrt(values.part[i]);
    return result;
}

HWY_INLINE Cells magnitude(const Cells& values) {
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Abs(values.part[i]);
    return result;
}

/// Computes ln x for x from 0.4 to 1: within 1e-4, and within 1e-7 from 0.8. The result is too large below
/// 0.4, by 0.05 at 0.1; x <= 0 counts as 1e-6.
HWY_INLINE Cells logarithm_near_one(const Cells& x) {
    // ln x = 2 artanh z.
    const Cells positive = larger(x, all_cells(1e-6f)), one = all_cells(1);
    const Cells z = (positive - one) / (positive + one), zz = z * z;
    Cells sum = all_cells(2.0f / 11);
    for (const float term : {2.0f / 9, 2.0f / 7, 2.0f / 5, 2.0f / 3, 2.0f})
        sum = multiply_add(sum, zz, all_cells(term));
    return sum * z;
}

/// Computes e^x for x <= 0, within 1e-6; 0 below -80.
HWY_INLINE Cells exponential(const Cells& x) {
    const hn::RebindToSigned<Floats> words;
    Cells result;
    for (std::size_t i = 0; i < parts; ++i) {
        const auto binary =
            hn::Mul(hn::Max(x.part[i], hn::Set(Floats(), -80.0f)), hn::Set(Floats(), 1.442695041f));
        const auto whole = hn::Round(binary);
        const auto rest = hn::Sub(binary, whole);
        auto power = hn::Set(Floats(), 1.339887e-3f);  // 2^rest, by a polynomial of degree 5.
        for (const float term : {9.618437e-3f, 5.550332e-2f, 2.402264e-1f, 6.931472e-1f, 1.0f})
            power = hn::MulAdd(power, rest, hn::Set(Floats(), term));
        const auto shift = hn::ShiftLeft<23>(hn::ConvertTo(words, whole));
        const auto scaled = hn::BitCast(Floats(), hn::Add(hn::BitCast(words, power), shift));
        result.part[i] = hn::IfThenElseZero(hn::Gt(x.part[i], hn::Set(Floats(), -80.0f)), scaled);
    }
    return result;
}

/// Replaces each cell by the mean over its run of 4 cells (a quadrant), or over all 16.
HWY_INLINE Cells means_of(const Cells& values, int run) {
#if HWY_TARGET != HWY_SCALAR
    if (run == 4) {  // The cells of a quadrant are one block of 128 bits.
        const auto half = hn::Set(Floats(), 0.5f);
        Cells result;
        for (std::size_t i = 0; i < parts; ++i) {
            const auto pairs = hn::Mul(hn::Add(values.part[i], hn::Shuffle2301(values.part[i])), half);
            result.part[i] = hn::Mul(hn::Add(pairs, hn::Shuffle1032(pairs)), half);
        }
        return result;
    }
#endif
    alignas(64) float cell[wide_cells];
    store_cells(values, cell);
    for (int step = 1; step < run; step *= 2)
        for (int i = 0; i < int(wide_cells); i += 2 * step)
            for (int k = i; k < i + step; ++k) cell[k] = cell[k + step] = (cell[k] + cell[k + step]) * 0.5f;
    return load_cells(cell);
}

/// Adds all cells in an order that does not depend on the length of vectors.
HWY_INLINE float sum_of(const Cells& values) {
#if HWY_TARGET == HWY_SCALAR
    alignas(64) float cell[wide_cells];
    store_cells(values, cell);
    for (std::size_t half = wide_cells / 2; half > 0; half /= 2)
        for (std::size_t i = 0; i < half; ++i) cell[i] += cell[i + half];
    return cell[0];
#else
    Cells sum = values;
    for (std::size_t half = parts / 2; half > 0; half /= 2)
        for (std::size_t i = 0; i < half; ++i) sum.part[i] = hn::Add(sum.part[i], sum.part[i + half]);
    auto all = sum.part[0];
#if HWY_MAX_BYTES == 64
    all = hn::Add(all, hn::ConcatLowerUpper(Floats(), all, all));
#endif
#if HWY_MAX_BYTES >= 32
    all = hn::Add(all, hn::SwapAdjacentBlocks(all));
#endif
    all = hn::Add(all, hn::Shuffle1032(all));
    return hn::GetLane(hn::Add(all, hn::Shuffle2301(all)));
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
