#include "shading/visibility/rasterized_visibility.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/visibility/rasterized_visibility.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef HAARFIELD_RASTERIZED_VISIBILITY_ONCE
#define HAARFIELD_RASTERIZED_VISIBILITY_ONCE

namespace haarfield {

/// Converts a number of unoccluded samples to visibility. [1/255]
constexpr std::uint8_t open_in_bytes(std::uint8_t count) {
    return static_cast<std::uint8_t>(32 * count - (count > 4));
}
static_assert([] {
    for (std::uint8_t count = 0; count <= samples_per_texel; ++count)
        if (open_in_bytes(count) != in_bytes(open_fraction(count))) return false;
    return true;
}());

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Converts numbers of unoccluded samples to visibility.
void convert_samples(const std::uint8_t* counts, std::size_t size, std::uint8_t* open) {
    const hn::ScalableTag<std::uint8_t> d;
    std::size_t i = 0;
    for (; i + hn::Lanes(d) <= size; i += hn::Lanes(d)) {
        const auto count = hn::LoadU(d, counts + i);
        const auto twice = [](auto number) { return hn::Add(number, number); };
        const auto scaled = twice(twice(twice(twice(twice(count)))));
        // A mask is -1 as a number.
        const auto many = hn::VecFromMask(d, hn::Gt(count, hn::Set(d, std::uint8_t(4))));
        hn::StoreU(hn::Add(scaled, many), d, open + i);
    }
    for (; i < size; ++i) open[i] = open_in_bytes(counts[i]);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(convert_samples);

RasterizedVisibility::RasterizedVisibility(int face_size)
    : rasterizer_(face_size),
      open_(std::size_t(cubemap_faces * face_size) * std::size_t(face_size)),
      maker_(face_size) {}

std::span<std::uint8_t> RasterizedVisibility::texels(std::span<const OccluderView> views) {
    if (views.empty()) {
        std::ranges::fill(open_, std::uint8_t(255));
    } else {
        const std::span<const std::uint8_t> counts = rasterizer_.open_samples(views);
        HWY_DYNAMIC_DISPATCH(convert_samples)(counts.data(), counts.size(), open_.data());
    }
    return open_;
}

const WideCubemap<std::uint8_t>& RasterizedVisibility::tree() {
    maker_.make(open_, tree_);
    return tree_.faces;
}

}  // namespace haarfield
#endif
