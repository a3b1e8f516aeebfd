/// Compaction of vectors: moves selected lanes to the front. Included once per instruction set, as Highway
/// requires.

#include <array>
#include <cstdint>

#ifndef HAARFIELD_FIELDS_LANE_COMPACTION_ONCE
#define HAARFIELD_FIELDS_LANE_COMPACTION_ONCE

namespace haarfield {

/// Indexed by a mask of up to eight lanes: the numbers of the set lanes in order.
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

/// A selection of 32-bit lanes. Like hn::Compress, but computes the permutation once for several vectors.
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
    /// Stores the selected lanes. The elements after them, up to a full vector, are undefined.
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
