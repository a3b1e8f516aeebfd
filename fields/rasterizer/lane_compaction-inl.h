/// Moves chosen lanes of vectors to the front. Included once per instruction set, as Highway wants it.

#include <array>
#include <cstdint>

#ifndef HAARFIELD_FIELDS_LANE_COMPACTION_ONCE
#define HAARFIELD_FIELDS_LANE_COMPACTION_ONCE

namespace haarfield {

/// By a mask of up to eight lanes: the numbers of its lanes, first to last.
inline constexpr std::array<std::array<std::uint8_t, 8>, 256> lanes_of_mask = [] {
    std::array<std::array<std::uint8_t, 8>, 256> lanes{};
    for (unsigned mask = 0; mask < 256; ++mask)
        for (unsigned lane = 0, at = 0; lane < 8; ++lane)
            if (mask >> lane & 1) lanes[mask][at++] = static_cast<std::uint8_t>(lane);
    return lanes;
}();

}  // namespace haarfield

#endif

#if defined(HAARFIELD_FIELDS_LANE_COMPACTION_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_FIELDS_LANE_COMPACTION_INL_H
#undef HAARFIELD_FIELDS_LANE_COMPACTION_INL_H
#else
#define HAARFIELD_FIELDS_LANE_COMPACTION_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// The lanes of a mask, for vectors of 32-bit lanes. As hn::Compress has them, but what can be shared between
/// vectors is worked out once.
template <class D>
class ChosenLanes {
public:
    HWY_INLINE ChosenLanes(D d, hn::Mask<D> mask) : count_(hn::CountTrue(d, mask)) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
        mask_ = mask;
#elif HWY_TARGET != HWY_SCALAR
        std::uint8_t bits[8] = {};
        hn::StoreMaskBits(d, mask, bits);
        const hn::Rebind<std::uint8_t, hn::RebindToSigned<D> > bytes;
        const hn::RebindToSigned<D> di;
        lanes_ = hn::IndicesFromVec(d, hn::PromoteTo(di, hn::LoadU(bytes, lanes_of_mask[bits[0]].data())));
#endif
    }
    /// Stores them; what is stored after them, up to a vector, does not matter.
    HWY_INLINE void store(hn::Vec<D> values, D d, hn::TFromD<D>* to) const {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
        hn::StoreU(hn::Compress(values, mask_), d, to);
#elif HWY_TARGET != HWY_SCALAR
        hn::StoreU(hn::TableLookupLanes(values, lanes_), d, to);
#else
        if (count_ != 0) hn::StoreU(values, d, to);
#endif
    }
    HWY_INLINE std::size_t count() const {
        return count_;
    }

private:
    std::size_t count_;
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
    hn::Mask<D> mask_;
#elif HWY_TARGET != HWY_SCALAR
    decltype(hn::IndicesFromVec(D(), hn::Zero(hn::RebindToSigned<D>()))) lanes_;
#endif
};

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
