#include "tests/baselines/dense_product.h"

#include <Imath/half.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

#include "fields/wavelets/cubemap.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/baselines/dense_product.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef HAARFIELD_DENSE_PRODUCT_ONCE
#define HAARFIELD_DENSE_PRODUCT_ONCE

namespace haarfield::baseline {

/// The number of texels that are skipped together.
inline constexpr std::size_t block = 64;

}  // namespace haarfield::baseline

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield::baseline {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;
using VF = hn::Vec<Floats>;

/// The partial integral, per lane.
struct Sums {
    VF red, green, blue;

    HWY_INLINE Sums() : red(hn::Zero(Floats())), green(red), blue(red) {}

    HWY_INLINE void add(const DenseLight& light, std::size_t i, VF product) {
        const Floats d;
        red = hn::MulAdd(product, hn::Load(d, light.channel[0].get() + i), red);
        green = hn::MulAdd(product, hn::Load(d, light.channel[1].get() + i), green);
        blue = hn::MulAdd(product, hn::Load(d, light.channel[2].get() + i), blue);
    }

    HWY_INLINE Rgb mean(std::size_t texels) const {
        const Floats d;
        const float scale = static_cast<float>(cubemap_faces) / static_cast<float>(texels);
        return Rgb(hn::GetLane(hn::SumOfLanes(d, red)), hn::GetLane(hn::SumOfLanes(d, green)),
                   hn::GetLane(hn::SumOfLanes(d, blue))) *
               scale;
    }
};

Rgb all_floats(const DenseLight& light, const DenseFloats& vertex) {
    const Floats d;
    Sums even, odd;  // two of each, to hide the latency of additions
    const std::size_t lanes = hn::Lanes(d);
    const auto product = [&](std::size_t i) HWY_ATTR {
        VF value = hn::Load(d, vertex.factors[0].get() + i);
        for (std::size_t k = 1; k < vertex.factors.size(); ++k)
            value = hn::Mul(value, hn::Load(d, vertex.factors[k].get() + i));
        return value;
    };
    for (std::size_t i = 0; i < light.texels; i += 2 * lanes) {
        even.add(light, i, product(i));
        odd.add(light, i + lanes, product(i + lanes));
    }
    return even.mean(light.texels) + odd.mean(light.texels);
}

Rgb open_floats(const DenseLight& light, const DenseFloats& vertex) {
    const Floats d;
    const std::size_t lanes = hn::Lanes(d);
    Sums sums;
    for (std::size_t first = 0; first < light.texels; first += block) {
        alignas(64) float open[block];
        VF any = hn::Zero(d);
        for (std::size_t i = 0; i < block; i += lanes) {
            VF value = hn::Load(d, vertex.factors[0].get() + first + i);
            for (std::size_t k = 2; k < vertex.factors.size(); ++k)
                value = hn::Mul(value, hn::Load(d, vertex.factors[k].get() + first + i));
            hn::Store(value, d, open + i);
            any = hn::Max(any, value);
        }
        if (hn::AllTrue(d, hn::Eq(any, hn::Zero(d)))) continue;
        for (std::size_t i = 0; i < block; i += lanes) {
            VF value = hn::Load(d, open + i);
            if (vertex.factors.size() > 1)
                value = hn::Mul(value, hn::Load(d, vertex.factors[1].get() + first + i));
            sums.add(light, first + i, value);
        }
    }
    return sums.mean(light.texels);
}

/// Loads half floats.
HWY_INLINE VF brdf_at(const std::uint16_t* brdf, std::size_t i) {
    const Floats d;
    const hn::Rebind<hwy::float16_t, Floats> half;
    return hn::PromoteTo(d, hn::Load(half, reinterpret_cast<const hwy::float16_t*>(brdf) + i));
}

/// Loads integers.
template <class T>
HWY_INLINE VF floats_at(const T* values, std::size_t i) {
    const Floats d;
    const hn::Rebind<T, Floats> from;
    const hn::Rebind<std::int32_t, Floats> integers;
    return hn::ConvertTo(d, hn::PromoteTo(integers, hn::Load(from, values + i)));
}

Rgb open_bytes(const DenseLight& light, const DenseBytes& vertex) {
    const Floats d;
    const std::size_t lanes = hn::Lanes(d);
    const hn::CappedTag<std::uint16_t, 32> words;
    const hn::Rebind<std::uint8_t, decltype(words)> bytes;
    const std::size_t count = vertex.visibility.size();
    // The product of own visibility (255) and two counts (8) fits 16 bits, and so does that of the next five
    // counts.
    const std::size_t with_own = std::min<std::size_t>(count, 2);
    const VF scale = hn::Set(d, 1.0f / (255 * std::pow(8.0f, static_cast<float>(count))));
    Sums sums;
    for (std::size_t first = 0; first < light.texels; first += block) {
        alignas(64) std::uint16_t near[block], far[block];
        auto any = hn::Zero(words);
        for (std::size_t i = 0; i < block; i += hn::Lanes(words)) {
            const auto at = [&](const AlignedArray<std::uint8_t>& values) HWY_ATTR {
                return hn::PromoteTo(words, hn::Load(bytes, values.get() + first + i));
            };
            auto value = at(vertex.own), rest = hn::Set(words, 1);
            for (std::size_t k = 0; k < with_own; ++k) value = hn::Mul(value, at(vertex.visibility[k]));
            for (std::size_t k = with_own; k < count; ++k) rest = hn::Mul(rest, at(vertex.visibility[k]));
            hn::Store(value, words, near + i);
            hn::Store(rest, words, far + i);
            any = hn::Or(any, hn::IfThenZeroElse(hn::Eq(rest, hn::Zero(words)), value));
        }
        if (hn::AllTrue(words, hn::Eq(any, hn::Zero(words)))) continue;
        for (std::size_t i = 0; i < block; i += lanes) {
            VF value = hn::Mul(hn::Mul(floats_at(near, i), scale), brdf_at(vertex.brdf.get(), first + i));
            if (with_own < count) value = hn::Mul(value, floats_at(far, i));
            sums.add(light, first + i, value);
        }
    }
    return sums.mean(light.texels);
}

Rgb open_bits(const DenseLight& light, const DenseBits& vertex) {
    const Floats d;
    const std::size_t lanes = hn::Lanes(d);
    const VF scale = hn::Set(d, 1.0f / 255);
    Sums sums;
    for (std::size_t first = 0; first < light.texels; first += block) {
        std::uint64_t open = ~std::uint64_t(0);
        for (const auto& plane : vertex.open) open &= plane[first / block];
        if (open == 0) continue;
        for (std::size_t i = 0; i < block; i += lanes) {
            const std::uint64_t here = open >> i;
            const auto is_open = hn::LoadMaskBits(d, reinterpret_cast<const std::uint8_t*>(&here));
            const VF value = hn::Mul(hn::Mul(floats_at(vertex.own.get(), first + i), scale),
                                     brdf_at(vertex.brdf.get(), first + i));
            sums.add(light, first + i, hn::IfThenElseZero(is_open, value));
        }
    }
    return sums.mean(light.texels);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield::baseline
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield::baseline {

HWY_EXPORT(all_floats);
HWY_EXPORT(open_floats);
HWY_EXPORT(open_bytes);
HWY_EXPORT(open_bits);

namespace {

/// Returns the index of the texel at each place in the blocks: along the Z curve of each face.
std::vector<std::size_t> block_order(std::size_t texels) {
    const auto size = static_cast<std::size_t>(std::lround(std::sqrt(double(texels) / cubemap_faces)));
    std::vector<std::size_t> order(texels);
    for (std::size_t i = 0; i < texels; ++i) {
        std::size_t column = 0, row = 0;
        for (std::size_t bit = 0; (std::size_t(1) << bit) < size; ++bit) {
            column |= (i >> (2 * bit) & 1) << bit;
            row |= (i >> (2 * bit + 1) & 1) << bit;
        }
        order[i] = i / (size * size) * size * size + row * size + column;
    }
    return order;
}

/// Converts texels, and arranges them in blocks.
template <class T, class Texel, class Conversion>
AlignedArray<T> in_blocks(std::span<const Texel> texels, const Conversion& value) {
    const std::vector<std::size_t> order = block_order(texels.size());
    AlignedArray<T> result = hwy::AllocateAligned<T>(texels.size());
    for (std::size_t i = 0; i < texels.size(); ++i) result[i] = value(texels[order[i]]);
    return result;
}

AlignedArray<float> floats_in_blocks(const std::vector<float>& texels) {
    return in_blocks<float>(std::span<const float>(texels), [](float value) { return value; });
}

AlignedArray<std::uint8_t> bytes_in_blocks(const std::vector<float>& texels, float scale) {
    return in_blocks<std::uint8_t>(std::span<const float>(texels), [scale](float value) {
        return static_cast<std::uint8_t>(std::lround(value * scale));
    });
}

AlignedArray<std::uint16_t> halves_in_blocks(const std::vector<float>& texels) {
    return in_blocks<std::uint16_t>(std::span<const float>(texels),
                                    [](float value) { return imath_float_to_half(value); });
}

AlignedArray<std::uint64_t> bits_in_blocks(const std::vector<float>& texels, float least) {
    const std::vector<std::size_t> order = block_order(texels.size());
    AlignedArray<std::uint64_t> result = hwy::AllocateAligned<std::uint64_t>(texels.size() / block);
    std::fill_n(result.get(), texels.size() / block, 0);
    for (std::size_t i = 0; i < texels.size(); ++i)
        if (texels[order[i]] >= least) result[i / block] |= std::uint64_t(1) << (i % block);
    return result;
}

constexpr float own_scale = 255, visibility_scale = 8;

}  // namespace

DenseLight dense_light(std::span<const Rgb> texels) {
    DenseLight light;
    light.texels = texels.size();
    for (int c = 0; c < 3; ++c)
        light.channel[c] = in_blocks<float>(texels, [c](const Rgb& value) { return value[c]; });
    return light;
}

DenseFloats dense_floats(std::span<const std::vector<float>> factors) {
    DenseFloats dense;
    for (const auto& factor : factors) dense.factors.push_back(floats_in_blocks(factor));
    return dense;
}

DenseBytes dense_bytes(std::span<const std::vector<float>> factors) {
    DenseBytes dense{bytes_in_blocks(factors[0], own_scale), halves_in_blocks(factors[1]), {}};
    for (const auto& factor : factors.subspan(2))
        dense.visibility.push_back(bytes_in_blocks(factor, visibility_scale));
    return dense;
}

DenseBits dense_bits(std::span<const std::vector<float>> factors) {
    DenseBits dense{bytes_in_blocks(factors[0], own_scale), halves_in_blocks(factors[1]), {}};
    dense.open.push_back(bits_in_blocks(factors[0], 0.5f / own_scale));
    for (const auto& factor : factors.subspan(2)) dense.open.push_back(bits_in_blocks(factor, 0.5f));
    return dense;
}

Rgb dense_product_scalar(const DenseLight& light, const DenseFloats& vertex) {
    Rgb sum(0.0f);
    for (std::size_t i = 0; i < light.texels; ++i) {
        float product = 1;
        for (const auto& factor : vertex.factors) product *= factor[i];
        sum += Rgb(light.channel[0][i], light.channel[1][i], light.channel[2][i]) * product;
    }
    return sum * (static_cast<float>(cubemap_faces) / static_cast<float>(light.texels));
}

Rgb dense_product(const DenseLight& light, const DenseFloats& vertex) {
    return HWY_DYNAMIC_DISPATCH(all_floats)(light, vertex);
}

Rgb dense_product_of_open(const DenseLight& light, const DenseFloats& vertex) {
    return HWY_DYNAMIC_DISPATCH(open_floats)(light, vertex);
}

Rgb dense_product(const DenseLight& light, const DenseBytes& vertex) {
    return HWY_DYNAMIC_DISPATCH(open_bytes)(light, vertex);
}

Rgb dense_product(const DenseLight& light, const DenseBits& vertex) {
    return HWY_DYNAMIC_DISPATCH(open_bits)(light, vertex);
}

}  // namespace haarfield::baseline
#endif
