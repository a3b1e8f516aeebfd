// Four floats, red, green, blue and one more, in as many vectors as the instruction set needs. Included once
// per instruction set, inside Highway's foreach_target.

#if defined(HAARFIELD_FOUR_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef HAARFIELD_FOUR_INL_H
#undef HAARFIELD_FOUR_INL_H
#else
#define HAARFIELD_FOUR_INL_H
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Four lanes whatever the machine has, and no fused multiply-add: the same bits everywhere.
using Floats = hn::CappedTag<float, 4>;
inline constexpr std::size_t parts = 4 / hn::MaxLanes(Floats());

struct Four {
    hn::Vec<Floats> part[parts];
};

HWY_INLINE Four all_four(float value) {
    Four result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Set(Floats(), value);
    return result;
}

HWY_INLINE Four load_four(const float* from) {
    Four result;
    for (std::size_t i = 0; i < parts; ++i)
        result.part[i] = hn::LoadU(Floats(), from + i * hn::MaxLanes(Floats()));
    return result;
}

HWY_INLINE void store_four(const Four& four, float* to) {
    for (std::size_t i = 0; i < parts; ++i)
        hn::StoreU(four.part[i], Floats(), to + i * hn::MaxLanes(Floats()));
}

HWY_INLINE Four operator*(const Four& a, const Four& b) {
    Four result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Mul(a.part[i], b.part[i]);
    return result;
}

HWY_INLINE Four operator+(const Four& a, const Four& b) {
    Four result;
    for (std::size_t i = 0; i < parts; ++i) result.part[i] = hn::Add(a.part[i], b.part[i]);
    return result;
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#endif
